//! The ports of one session: links belong to addresses, not to drivers.

use std::collections::BTreeSet;
use std::sync::{Arc, PoisonError};

use isolux_conversation::Conversation;
use isolux_device::{OpenError, Target};
use tokio::sync::Mutex;

use crate::owner::things;
use crate::port::Port;
use crate::{Bus, LineSettings, Links, UsbProfile};

/// Opens every address once and hands the port to each device on it. Two names of one port, as a link to it or another
/// name of a host, are the same address.
pub struct Ports {
    links: Arc<dyn Links>,
    known: std::sync::Mutex<Vec<Arc<Known>>>,
}

/// An address that was asked for.
struct Known {
    /// What is behind it, by all its names.
    things: BTreeSet<String>,
    /// Kept while it is opened: one that does not open must not keep others waiting.
    open: Mutex<Option<Open>>,
}

/// A port that is open.
struct Open {
    /// Who opened it.
    first: Target,
    line: LineSettings,
    port: Port,
}

impl Ports {
    /// Ports whose links are opened by `links`.
    pub fn new(links: Arc<dyn Links>) -> Arc<Self> {
        Arc::new(Self {
            links,
            known: std::sync::Mutex::default(),
        })
    }

    /// The port of `target` in the language `C`, opened now if it is not yet, or if its link was lost. It stays open
    /// until the registry and all handles are gone. The first device of a language on a port brings the conversation by
    /// `begin`; all others of that language share it, because what was asked before concerns the line and not the
    /// device.
    ///
    /// # Errors
    /// [`OpenError::Address`] when another device uses the port with other line settings; [`OpenError::Link`].
    pub async fn bus<C: Conversation>(
        &self,
        target: &Target,
        line: LineSettings,
        begin: impl FnOnce() -> C,
    ) -> Result<Bus<C>, OpenError> {
        self.join(target, line, None, begin).await
    }

    /// The same for an instrument that can also be reached over USB, as `profile` says.
    ///
    /// # Errors
    /// As [`bus`](Self::bus).
    pub async fn usb_bus<C: Conversation>(
        &self,
        target: &Target,
        line: LineSettings,
        profile: &'static UsbProfile,
        begin: impl FnOnce() -> C,
    ) -> Result<Bus<C>, OpenError> {
        self.join(target, line, Some(profile), begin).await
    }

    async fn join<C: Conversation>(
        &self,
        target: &Target,
        line: LineSettings,
        profile: Option<&'static UsbProfile>,
        begin: impl FnOnce() -> C,
    ) -> Result<Bus<C>, OpenError> {
        let known = self.known(target.link()).await;
        let mut open = known.open.lock().await;
        if let Some(open) = open.as_ref().filter(|open| !open.port.is_closed()) {
            open.shares_with(target, line)?;
            return Ok(Bus::on(open.port.clone(), begin).await);
        }
        let link = match profile.filter(|_| target.link().starts_with("usb:")) {
            Some(profile) => self.links.open_usb(target.link(), line, profile).await,
            None => self.links.open(target.link(), line).await,
        };
        let port = Port::spawn(link.map_err(|error| error.opening(target))?, target.link());
        let bus = Bus::on(port.clone(), begin).await;
        *open = Some(Open {
            first: target.clone(),
            line,
            port,
        });
        Ok(bus)
    }

    async fn known(&self, address: &str) -> Arc<Known> {
        // Without a name of its own it is opened by its address, which says what is wrong with it.
        let things = things(address).await.unwrap_or_else(|_| [address.to_owned()].into());
        let mut all = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = all.iter().find(|known| !known.things.is_disjoint(&things)) {
            return Arc::clone(known);
        }
        let known = Arc::new(Known {
            things,
            open: Mutex::default(),
        });
        all.push(Arc::clone(&known));
        known
    }
}

impl Open {
    /// Whether `target` can use this port too.
    fn shares_with(&self, target: &Target, line: LineSettings) -> Result<(), OpenError> {
        let scheme = |target: &Target| target.link().split_once("://").map(|(scheme, _)| scheme.to_owned());
        if scheme(&self.first) != scheme(target) {
            return Err(target.wrong(format!(
                "`{}` has the same port open and frames its bytes in another way; write both addresses alike",
                self.first
            )));
        }
        match conflict(&self.first, self.line, target, line) {
            Some(reason) => Err(target.wrong(reason)),
            None => Ok(()),
        }
    }
}

/// Why two devices cannot share a port, if they cannot: a line has one speed and one parity.
pub fn conflict(first: &Target, first_line: LineSettings, second: &Target, line: LineSettings) -> Option<String> {
    // Neither a network protocol nor USB has such settings.
    let settings_count = !["modbus-tcp://", "usb:"]
        .iter()
        .any(|scheme| second.link().starts_with(scheme));
    (settings_count && first_line != line).then(|| {
        format!(
            "`{second}` needs {line} and `{first}` needs {first_line} on the same port: set both devices to the same line \
             settings, or give each a port of its own"
        )
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::time::Instant;

    use async_trait::async_trait;
    use isolux_conversation::{Event, Start};

    use super::*;
    use crate::{Link, LinkError, MemoryLinks, Parity};

    /// Says nothing; only its type matters.
    #[derive(Default)]
    struct Mute<const LANGUAGE: u8>;

    impl<const LANGUAGE: u8> Conversation for Mute<LANGUAGE> {
        type Request = ();
        type Answer = ();

        fn start(&mut self, _: Instant, (): ()) -> Start<()> {
            Start {
                frame: vec![LANGUAGE],
                at_once: Some(()),
            }
        }

        fn handle_input(&mut self, _: Instant, _: &[u8]) -> Vec<Event<()>> {
            Vec::new()
        }

        fn abandon(&mut self, _: Instant) -> Vec<u8> {
            Vec::new()
        }
    }

    const LINE: LineSettings = LineSettings {
        baud: 9600,
        data_bits: 8,
        parity: Parity::None,
        stop_bits: 1,
    };

    /// Pipes under every address, counted.
    #[derive(Default)]
    struct Pipes {
        memory: MemoryLinks,
        opened: Mutex<Vec<String>>,
    }

    #[async_trait]
    impl Links for Pipes {
        async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
            self.opened.lock().unwrap().push(address.to_owned());
            self.memory.open("memory:x", line).await
        }
    }

    fn target(text: &str) -> Target {
        Target::parse(text).unwrap()
    }

    fn soon() -> tokio::time::Instant {
        tokio::time::Instant::now() + std::time::Duration::from_secs(1)
    }

    #[cfg(unix)]
    #[tokio::test]
    async fn an_address_is_opened_once_by_whatever_name_and_again_when_it_was_lost() {
        let folder = tempfile::tempdir().unwrap();
        let by_id = folder.path().join("by-id");
        std::os::unix::fs::symlink("/dev/null", &by_id).unwrap();
        let pipes = Arc::new(Pipes::default());
        let mut twin = pipes.memory.listen("x").unwrap();
        let ports = Ports::new(pipes.clone());
        let first = ports
            .bus(&target("a:/dev/null?n=1"), LINE, Mute::<1>::default)
            .await
            .unwrap();
        let other = target(&format!("b:{}?n=2", by_id.display()));
        let second = ports.bus(&other, LINE, Mute::<2>::default).await.unwrap();
        assert_eq!(pipes.opened.lock().unwrap().len(), 1);
        first.ask((), soon()).await.unwrap();
        second.ask((), soon()).await.unwrap();
        let mut heard = [0; 2];
        let mut stream = twin.accept().await.unwrap();
        tokio::io::AsyncReadExt::read_exact(&mut stream, &mut heard)
            .await
            .unwrap();
        assert_eq!(heard, [1, 2]);
        drop(stream);
        while !first.is_closed() {
            tokio::task::yield_now().await;
        }
        let again = ports.bus(&other, LINE, Mute::<2>::default).await.unwrap();
        assert!(!again.is_closed() && second.is_closed());
        assert_eq!(pipes.opened.lock().unwrap().len(), 2);
        let elsewhere = ports.bus(&target("b:/dev/zero"), LINE, Mute::<2>::default).await;
        assert!(elsewhere.is_ok() && pipes.opened.lock().unwrap().len() == 3);
    }

    #[tokio::test(start_paused = true)]
    async fn a_port_that_does_not_open_keeps_no_other_waiting() {
        /// One address takes an hour.
        struct Slow(MemoryLinks);

        #[async_trait]
        impl Links for Slow {
            async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
                if address == "memory:slow" {
                    tokio::time::sleep(std::time::Duration::from_hours(1)).await;
                }
                self.0.open(address, line).await
            }
        }

        let memory = MemoryLinks::default();
        let _twin = memory.listen("x").unwrap();
        let ports = Ports::new(Arc::new(Slow(memory)));
        let (slow, quick) = (target("a:memory:slow"), target("a:memory:x"));
        let waiting = ports.bus(&slow, LINE, Mute::<1>::default);
        let answered = async {
            tokio::task::yield_now().await;
            ports.bus(&quick, LINE, Mute::<1>::default).await
        };
        tokio::select! {
            _ = waiting => panic!("the slow one came first"),
            quick = answered => assert!(quick.is_ok()),
        }
    }

    #[tokio::test]
    async fn two_line_settings_and_two_framings_of_one_port_are_refused_by_both_addresses() {
        let pipes = Arc::new(Pipes::default());
        let _twin = pipes.memory.listen("x").unwrap();
        let ports = Ports::new(pipes.clone());
        let mute = Mute::<1>::default;
        ports.bus(&target("a:/dev/null"), LINE, mute).await.unwrap();
        let even = LineSettings {
            data_bits: 7,
            parity: Parity::Even,
            ..LINE
        };
        let refused = ports
            .bus(&target("b:/dev/null?n=2"), even, mute)
            .await
            .err()
            .unwrap()
            .to_string();
        for part in ["`b:/dev/null?n=2` needs 9600 7E1", "`a:/dev/null` needs 9600 8N1"] {
            assert!(refused.contains(part), "{refused}");
        }
        ports.bus(&target("a:tcp://localhost:4009"), LINE, mute).await.unwrap();
        let framed = ports.bus(&target("b:modbus-tcp://127.0.0.1:4009"), LINE, mute).await;
        assert!(framed.err().unwrap().to_string().contains("a:tcp://localhost:4009"));
        ports
            .bus(&target("a:modbus-tcp://localhost:4010"), LINE, mute)
            .await
            .unwrap();
        let network = ports
            .bus(&target("b:modbus-tcp://localhost:4010?n=2"), even, mute)
            .await;
        assert!(network.is_ok(), "a network protocol has no parity");
    }
}
