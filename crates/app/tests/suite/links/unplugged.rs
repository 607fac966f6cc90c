//! Each instrument of the default station is unplugged at many moments of a scan, in virtual time: the scan ends with
//! one message that says who it was and what to do, and the axes rest where they can still be asked.

use camino::Utf8PathBuf;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session;
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_app::{Failure, FailureKind, init};
use isolux_darkroom::Darkroom;
use isolux_record::Run;
use isolux_record::run::StopHow;
use isolux_virtual::twins::Choice;

use super::{FAST, hasty, plan};

/// Moments at which an instrument is unplugged.
const MOMENTS: u32 = 10;

/// How the scan ends and how long it takes when `instrument` is unplugged at `at_s`; its run, if it began one.
fn scanned(instrument: &str, at_s: f64) -> (Result<f64, Failure>, Option<Run>) {
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    let text = format!("{FAST}[[fault]]\ninstrument = {instrument:?}\nkind = \"disconnect\"\nat_s = {at_s:?}\n");
    let ended = session::run(true, async {
        let choice = Choice::default();
        let (station, calibration) = init::virtual_station(&choice).unwrap();
        let source = StationFiles::from_text(&hasty(&station), calibration.as_deref()).unwrap();
        let session = session::Session::in_room(Darkroom::parse(&text).unwrap(), &choice).unwrap();
        let mut devices = source.open(&Catalogue::new(session.links.clone())).await?;
        let now = "2026-01-01T00:00:00Z".parse().unwrap();
        let job = ScanJob {
            source: &source,
            plan: &plan(6),
            place: Place::take(Target::New(&path), false)?,
            force: None,
            operator: None,
            control: &Control::default(),
            progress: &Silent,
        };
        job.execute_on(&mut devices, None, now).await?;
        Ok(session.room.as_ref().unwrap().now_s())
    });
    (ended, Run::read(&path).ok())
}

#[test]
fn unplugged_at_any_moment_it_says_who_and_what_to_do() {
    for (instrument, word) in [
        ("axes", "axes"),
        ("luxmeter", "luxmeter"),
        ("spectroradiometer", "spectrometer"),
    ] {
        let whole_s = scanned(instrument, 1e6).0.unwrap();
        let mut failures = 0;
        for moment in 0..MOMENTS {
            let at_s = whole_s * f64::from(moment) / f64::from(MOMENTS);
            let (ended, run) = scanned(instrument, at_s);
            // What is not needed any more is not missed.
            let Err(failure) = ended else { continue };
            failures += 1;
            let stated = format!("{instrument} at {at_s:.1} s: {failure:?}");
            assert_eq!(failure.kind, FailureKind::Instrument, "{stated}");
            assert!(failure.message.contains(word), "{stated}");
            assert!(failure.help.is_some(), "{stated}");
            if let Some(stopped) = run.and_then(|run| run.header.stopped) {
                let expected = (StopHow::Failed, instrument != "axes");
                assert_eq!((stopped.how, stopped.axes_at_rest), expected, "{stated}");
            }
        }
        assert!(failures >= 4, "{instrument}: {failures} of {MOMENTS}");
    }
}
