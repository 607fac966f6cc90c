//! What the page shows of a scan from its record is what it showed while the scan ran.

use std::cell::RefCell;

use camino::Utf8Path;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::live::{Event as ScanEvent, Live, Outline, Remaining};
use isolux_app::front_end::progress::{Event, Progress};
use isolux_app::init;
use isolux_app::run::replay::Replay;
use isolux_app::scan::{self, Place, ScanJob, Target};
use isolux_virtual::twins::Choice;

const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "lit"
kind = "lit"
c_deg = [0, 90]
gamma_deg = [0, 30, 60]
reference_every = 3
[[block]]
name = "spectrum"
kind = "lit"
instrument = "spectroradiometer"
c_deg = 0
gamma_deg = 0
repeats = 2
[[block]]
name = "off"
kind = "lamp_off"
c_deg = 0
gamma_deg = 0
repeats = 3
"#;

#[derive(Default)]
struct Shown {
    outline: RefCell<Option<Outline>>,
    live: RefCell<Vec<Live>>,
}

impl Progress for Shown {
    fn event(&self, event: Event<'_>) {
        match event {
            Event::Outline(outline) => *self.outline.borrow_mut() = Some(outline.clone()),
            Event::Live(live) => self.live.borrow_mut().push(live.clone()),
            _ => {}
        }
    }
}

#[test]
fn a_record_shows_what_was_shown_live() {
    let keep = tempfile::tempdir().unwrap();
    let folder = Utf8Path::from_path(keep.path()).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    let (station, calibration) = init::virtual_station(&Choice::default()).unwrap();
    write("station.toml", &station);
    write(isolux_virtual::station::CALIBRATION_FILE, &calibration.unwrap());
    write("plan.toml", PLAN);
    let (run, shown) = (folder.join("run"), Shown::default());
    let (station, plan) = (folder.join("station.toml"), folder.join("plan.toml"));
    let (source, plan, _) = scan::checked(&station, &plan, false).unwrap();
    let job = ScanJob {
        source: &source,
        plan: &plan,
        place: Place::take(Target::New(&run), false).unwrap(),
        force: None,
        operator: None,
        control: &Control::default(),
        progress: &shown,
    };
    job.execute().unwrap();

    let mut live = shown.live.into_inner();
    let last = live.pop().unwrap();
    assert!(
        last.sentence.unwrap().contains("readings"),
        "what no event says comes last"
    );
    let (outline, record) = Replay::of(&run).further().unwrap();
    assert_eq!(outline, shown.outline.into_inner());
    // A row is recorded after the middle of its integration, which is its time in the record.
    let without_time = |all: &[Live]| -> Vec<Live> {
        let mut all = all.to_vec();
        for live in &mut all {
            if matches!(live.logged.event, ScanEvent::Reading(_) | ScanEvent::Spectrum { .. }) {
                live.logged.time_utc.clear();
            }
            live.left = live.left.take().map(|left| Remaining {
                left_s: 0.0,
                ends_utc: String::new(),
                ..left
            });
        }
        all
    };
    let (live, record) = (without_time(&live), without_time(&record));
    assert!(live.len() > 80, "{}", live.len());
    for (live, record) in live.iter().zip(&record) {
        assert_eq!(live, record);
    }
    assert_eq!(live.len(), record.len());
}
