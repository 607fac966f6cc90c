//! A scan by the program in the virtual room.

use camino::Utf8PathBuf;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::init;
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session::{self, Session};
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_darkroom::Darkroom;
use isolux_record::{Plan, Run};
use isolux_virtual::twins::Choice;

/// The record of `plan` in `room`, by the default twins.
pub fn scanned(room: Darkroom, plan: &Plan) -> Run {
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    let (station, calibration) = init::virtual_station(&Choice::default()).unwrap();
    let source = StationFiles::from_text(&station, calibration.as_deref()).unwrap();
    session::run(true, async {
        let session = Session::in_room(room, &Choice::default())?;
        let catalogue = Catalogue::new(session.links.clone());
        let mut devices = source.open(&catalogue).await?;
        let now = "2026-01-01T00:00:00Z".parse().unwrap();
        let job = ScanJob {
            source: &source,
            plan,
            place: Place::take(Target::New(&path), false)?,
            force: None,
            operator: None,
            control: &Control::default(),
            progress: &Silent,
        };
        job.execute_on(&mut devices, None, now).await
    })
    .unwrap();
    Run::read(&path).unwrap()
}
