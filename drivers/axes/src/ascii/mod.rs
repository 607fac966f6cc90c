//! Axes with a simple ASCII language, by a profile: `ascii-axis:LINK?profile=FILE.toml&address=1`.
//!
//! `profile` is the path of a TOML file, from the folder of the station file; `template` is one that shows every key
//! and is no real drive. `address` stands for `{address}` in the profile.
//!
//! These languages have neither checks nor numbers. Every command is followed by a look at what became of it, and looks
//! count as `polled.rs` says. After a lost reply the command of `[identity]` must be answered before anything is asked
//! again.

mod drive;
mod profile;

use std::sync::Arc;

use isolux_device::{AxisSettings, Coordinate, Factories, Kind, OpenError, Target};
use isolux_protocol_ascii::{Lines, Plain};
use isolux_transport::{Driver, Place, Ports, no_display};

use crate::factory::axis_factory;
use crate::polled::PolledAxis;
use drive::{Described, NAME};
use profile::Profile;

/// Axes in plain ASCII.
pub const ASCII_AXIS: Driver = Driver {
    name: NAME,
    speaks_to: "turntables and rails in simple ASCII by a profile",
    examples: &[(Kind::Axis, "ascii-axis:/dev/ttyUSB0?profile=template&address=1")],
    seen_with: "🧪 the virtual twin of the template",
    usb: &[],
    // Every language is another one: what could be asked stands in a profile.
    identify: &[],
    place: |target, _| {
        let line = profile(target)?.line;
        let address = target.option("address");
        let channel = address.map(|address| format!("drive {address}")).unwrap_or_default();
        Ok(Place { channel, line })
    },
    display_lx: no_display,
    factories: |ports| Factories {
        axis: Some(Arc::new(AsciiAxisDriver { ports })),
        ..Factories::default()
    },
};

fn profile(target: &Target) -> Result<Profile, OpenError> {
    target.only(&["profile", "address"])?;
    Profile::of(target)
}

struct AsciiAxisDriver {
    ports: Arc<Ports>,
}

impl AsciiAxisDriver {
    async fn axis<P: Coordinate>(
        &self,
        target: &Target,
        settings: AxisSettings<P>,
    ) -> Result<PolledAxis<P, Described<P>>, OpenError> {
        let profile = profile(target)?;
        let bus = self.ports.bus(target, profile.line, Lines::<Plain>::default).await?;
        Ok(PolledAxis::new(Described::open(bus, target, profile, settings).await?))
    }
}

axis_factory!(AsciiAxisDriver);
