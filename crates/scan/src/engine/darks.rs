//! A lux meter that needs its dark, on a bench of fakes.

use isolux_device::LuxMeterProperties;
use isolux_record::Event;

use super::tests::{DAY, scan};
use crate::cancel::Cancel;
use crate::testing::fakes::FakeMeter;
use crate::testing::{bench, plan, run_dir};

#[tokio::test(start_paused = true)]
async fn the_dark_is_taken_once_behind_the_shutter_before_anything_is_read() {
    for needs_dark in [true, false] {
        let (mut devices, room) = bench();
        room.lock().unwrap().shutter_open = true;
        devices.meter = Box::new(FakeMeter {
            identity: devices.meter.identity().clone(),
            properties: LuxMeterProperties {
                needs_dark,
                ..devices.meter.properties().clone()
            },
            room: room.clone(),
        });
        let plan = plan(DAY);
        let (_keep, path, mut run) = run_dir(&devices, &plan);
        scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await.unwrap();
        let room = room.lock().unwrap();
        let darks: Vec<&String> = room.log.iter().filter(|line| line.starts_with("dark")).collect();
        let noted = isolux_record::event::read(&path)
            .into_iter()
            .filter(|logged| matches!(&logged.event, Event::Note { message } if message == "its dark was taken"));
        assert_eq!(noted.count(), usize::from(needs_dark));
        if needs_dark {
            assert_eq!(darks, ["dark after 0 readings, open: false"]);
        } else {
            assert!(darks.is_empty(), "{darks:?}");
        }
    }
}
