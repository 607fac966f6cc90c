//! A lux meter of any [`Language`], and how the catalogue opens one.

use std::sync::Arc;

use async_trait::async_trait;
use isolux_device::{
    Conversions, DeviceError, Factories, Identity, Kind, LuxMeter, LuxMeterFactory, LuxMeterProperties, LuxRange,
    LuxReading, LuxSample, OpenError, Target,
};
use isolux_transport::{Place, Ports};
use isolux_units::Lux;
use tokio::time::Instant;

use crate::confirmed::State;
use crate::connected::Connected;
use crate::language::{Converts, Language, Link};

/// For [`Driver::place`](isolux_transport::Driver).
pub(crate) fn place<L: Language>(target: &Target, _: Kind) -> Result<Place, OpenError> {
    Ok(L::of(target)?.place())
}

/// For [`Driver::display_lx`](isolux_transport::Driver).
pub(crate) fn display_lx<L: Language>(target: &Target) -> Vec<(f64, f64)> {
    let ranges = L::of(target).map(|meter| meter.ranges_lx()).unwrap_or_default();
    let known = |(top_lx, digit_lx): (f64, Option<f64>)| Some((top_lx, digit_lx?));
    ranges.into_iter().filter_map(known).collect()
}

/// For [`Driver::factories`](isolux_transport::Driver).
pub(crate) fn factories<L: Language>(ports: Arc<Ports>) -> Factories {
    Factories {
        lux_meter: Some(Arc::new(Opener { ports, open: L::of })),
        ..Factories::default()
    }
}

struct Opener<L> {
    ports: Arc<Ports>,
    open: fn(&Target) -> Result<L, OpenError>,
}

#[async_trait]
impl<L: Language> LuxMeterFactory for Opener<L> {
    async fn open_lux_meter(&self, target: &Target) -> Result<Box<dyn LuxMeter>, OpenError> {
        let mut language = (self.open)(target)?;
        let begin = || language.conversation(target);
        let link = Link {
            bus: self.ports.bus(target, language.place().line, begin).await?,
            name: target.to_string(),
        };
        let mut identity = Identity {
            driver: L::NAME,
            target: target.to_string(),
            model: language.model(),
            serial: None,
            firmware: None,
        };
        language.put_in_service(&link, &mut identity).await?;
        let tops = language.ranges_lx().into_iter();
        let properties = LuxMeterProperties {
            range_full_scale: tops.filter_map(|(top_lx, _)| Lux::new(top_lx).ok()).collect(),
            update_interval: language.timing().update_interval,
            integration: language.timing().integration,
            range_integration: Vec::new(),
            needs_dark: false,
            converts: match (language.timing().converts, language.soonest()) {
                (Converts::OnRequest, _) => Conversions::OnRequest,
                (Converts::Always | Converts::AlwaysAndRepeats, Some(_)) => Conversions::ByOwnClock,
                (Converts::Always | Converts::AlwaysAndRepeats, None) => Conversions::Unknown,
            },
        };
        // What has arrived by now was part of putting the meter into service.
        let state = State::in_step(link.bus.unsolicited());
        Ok(Box::new(Meter {
            connected: Connected::new(link, language),
            identity,
            properties,
            state: tokio::sync::Mutex::new(state),
        }))
    }
}

/// A meter that has been put into service.
struct Meter<L: Language> {
    connected: Connected<L>,
    identity: Identity,
    properties: LuxMeterProperties,
    /// Kept by whoever reads or sets something.
    state: tokio::sync::Mutex<State>,
}

#[async_trait]
impl<L: Language> LuxMeter for Meter<L> {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn properties(&self) -> &LuxMeterProperties {
        &self.properties
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<LuxReading, DeviceError> {
        let mut state = self.state.lock().await;
        state.confirmed(&self.connected, not_before, deadline).await
    }

    async fn sample(&self, deadline: Instant) -> Result<LuxSample, DeviceError> {
        self.state.lock().await.sample(&self.connected, deadline).await
    }

    async fn set_range(&self, range: LuxRange) -> Result<(), DeviceError> {
        // A reading under way ends in the range in which it began.
        let mut state = self.state.lock().await;
        let Connected { link, language, .. } = &self.connected;
        let steps = language.choosing(range);
        let steps = steps.map_err(|reason| DeviceError::Unsupported {
            device: link.name.clone(),
            action: match range {
                LuxRange::Auto => "use the automatic range".to_owned(),
                LuxRange::Fixed(number) => format!("use range {number}"),
            },
            reason,
        })?;
        for step in steps {
            let mut same = self.identity.clone();
            link.settle(language, step, &mut same).await?;
            state.forget();
        }
        self.connected.chosen(range);
        Ok(())
    }

    async fn take_dark(&self, _: Instant) -> Result<Option<String>, DeviceError> {
        Ok(None)
    }
}
