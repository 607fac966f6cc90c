//! One table of faults for every driver of an axis: whatever the language, a fault at the same moment of the same step
//! ends in the same way. The table of twins says which drivers there are, so that none is left out.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::sync::Arc;
use std::time::Duration;

use isolux_darkroom::Darkroom;
use isolux_device::{Axis, AxisPosition, AxisScale, AxisSettings, DeviceError, ErrorKind, Sense, Target};
use isolux_transport::{MemoryLinks, Ports};
use isolux_units::AxisAngle;
use isolux_virtual::twins::{Choice, TWINS, TwinKind};
use isolux_virtual::{AxisName, Instrument, Serving, VirtualRoom};
use tokio::time::{Instant, sleep};

/// What is done while the fault happens; the axis has been homed and rests at 0° before.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    /// Asks where the axis is.
    Position,
    /// Searches the reference, from 60° on.
    Home,
    /// Moves to 90°, which takes 5 s.
    Move,
    /// The same, given up after 1 s.
    MoveTooSlow,
    /// Searches the reference, given up after 1 s.
    HomeTooSlow,
    /// Stops 1 s after the beginning of that move.
    Stop,
}

/// How the step must end.
#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    /// As without the fault.
    Done,
    /// Done; or refused and stopped, by a drive that obeys the command whose reply was lost and takes no second.
    DoneOr(ErrorKind),
    /// With this error, and the axis stopped.
    Stopped(ErrorKind),
    /// With this error, and nobody knows: the link is gone.
    Unknown(ErrorKind),
}

use End::{Done, DoneOr, Stopped, Unknown};
use ErrorKind::{Disconnected, Fault, Refused, Timeout};

/// Step, fault in the words of `virtual --faults`, end.
const TABLE: &[(Step, &str, End)] = &[
    // One reply is lost, late or damaged: asked again, and nothing else happens.
    (Step::Position, "axes silent", Done),
    (Step::Position, "axes late delay_s=0.3", Done),
    (Step::Position, "axes late delay_s=1.5", Done),
    (Step::Position, "axes drop_byte", Done),
    (Step::Position, "axes flip_bit", Done),
    (Step::Home, "axes silent", DoneOr(Refused)),
    (Step::Home, "axes late delay_s=0.3", Done),
    (Step::Home, "axes silent at_s=1", Done),
    (Step::Home, "axes drop_byte at_s=1", Done),
    (Step::Home, "axes flip_bit at_s=1", Done),
    (Step::Move, "axes silent", Done),
    (Step::Move, "axes late delay_s=0.3", Done),
    (Step::Move, "axes silent at_s=1", Done),
    (Step::Move, "axes late at_s=1 delay_s=1.5", Done),
    (Step::Move, "axes drop_byte at_s=1", Done),
    (Step::Move, "axes flip_bit at_s=1", Done),
    (Step::Move, "axes silent at_s=5.05", Done),
    (Step::Stop, "axes silent", Done),
    (Step::Stop, "axes late delay_s=0.3", Done),
    (Step::Stop, "axes drop_byte", Done),
    (Step::Stop, "axes flip_bit", Done),
    // No reply for longer than all tries take.
    (Step::Position, "axes silent for_s=60", Unknown(Timeout)),
    (Step::Home, "axes silent at_s=1 for_s=60", Unknown(Timeout)),
    (Step::Move, "axes silent at_s=1 for_s=60", Unknown(Timeout)),
    (Step::Stop, "axes silent for_s=60", Unknown(Timeout)),
    // The link ends.
    (Step::Position, "axes disconnect for_s=60", Unknown(Disconnected)),
    (Step::Home, "axes disconnect at_s=1 for_s=60", Unknown(Disconnected)),
    (Step::Move, "axes disconnect at_s=1 for_s=60", Unknown(Disconnected)),
    (Step::Stop, "axes disconnect for_s=60", Unknown(Disconnected)),
    // It is still on its way when the time is over.
    (Step::HomeTooSlow, "clear axes", Stopped(Timeout)),
    (Step::MoveTooSlow, "clear axes", Stopped(Timeout)),
    // The axis is held, or the drive switches off.
    (Step::Home, "axes stall at_s=0.5", Stopped(Fault)),
    (Step::Move, "axes stall at_s=1", Stopped(Fault)),
    (Step::Home, "axes alarm at_s=1", Stopped(Fault)),
    (Step::Move, "axes alarm at_s=1", Stopped(Fault)),
];

/// The profile that this twin speaks has no word for an alarm.
const WITHOUT_ALARM: &str = "ascii-axis";

struct Bench {
    room: VirtualRoom,
    links: MemoryLinks,
    _serving: Serving,
}

impl Bench {
    fn of(twin: &TwinKind) -> Self {
        let mut choice = Choice::default();
        choice.choose(Instrument::Axes, twin.driver).unwrap();
        let room = VirtualRoom::open_with(Darkroom::default(), &choice);
        let links = MemoryLinks::default();
        let serving = room.listen(&links).unwrap();
        Self {
            room,
            links,
            _serving: serving,
        }
    }

    async fn open(&self, twin: &TwinKind) -> Box<dyn Axis> {
        let driver = isolux_axes::DRIVERS.iter().find(|driver| driver.name == twin.driver);
        let ports = Ports::new(Arc::new(self.links.clone()));
        let factory = (driver.unwrap().factories)(ports).axis.unwrap();
        let (pipe, rest) = (VirtualRoom::pipe(Instrument::Axes), twin.open("axis.gamma").unwrap());
        let target = Target::parse(&format!("{}:memory:{pipe}{rest}", twin.driver)).unwrap();
        let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
        let settings = AxisSettings::new(scale, (angle(-180.0), angle(180.0)), 20.0, 40.0).unwrap();
        factory.open_axis(&target, settings).await.unwrap()
    }

    /// Where the axis truly is, in steps, and whether it moves.
    fn truth(&self) -> (f64, bool) {
        self.room.with_world(|world, now_s| {
            let motion = &world.axis(AxisName::Gamma).motion;
            (motion.position(now_s), motion.moving(now_s))
        })
    }
}

fn angle(deg: f64) -> AxisAngle {
    AxisAngle::new(deg).unwrap()
}

fn soon() -> Instant {
    Instant::now() + Duration::from_secs(30)
}

async fn carry_out(bench: &Bench, axis: &dyn Axis, step: Step, fault: &str) -> Result<AxisPosition, DeviceError> {
    axis.home(soon()).await.unwrap();
    if matches!(step, Step::Home | Step::HomeTooSlow) {
        axis.move_to(angle(60.0)).await.unwrap();
    }
    let a_second = || Instant::now() + Duration::from_secs(1);
    let inject = || assert!(bench.room.order(&fault.parse().unwrap()));
    match step {
        Step::Position => {
            inject();
            axis.position().await
        }
        Step::Home => {
            inject();
            axis.home(soon()).await
        }
        Step::HomeTooSlow => axis.home(a_second()).await,
        Step::Move => {
            inject();
            axis.move_to(angle(90.0)).await
        }
        Step::MoveTooSlow => {
            let mut motion = axis.start_move(angle(90.0)).await?;
            motion.deadline = a_second();
            axis.finish_move(motion).await
        }
        Step::Stop => {
            axis.start_move(angle(90.0)).await?;
            sleep(Duration::from_secs(1)).await;
            inject();
            axis.stop().await
        }
    }
}

#[tokio::test(start_paused = true)]
async fn every_driver_meets_the_table_in_the_same_way() {
    let mut wrong = Vec::new();
    for twin in TWINS.iter().filter(|twin| twin.instrument == Instrument::Axes) {
        for (step, fault, end) in TABLE {
            if twin.driver == WITHOUT_ALARM && fault.contains("alarm") {
                continue;
            }
            let bench = Bench::of(twin);
            let axis = bench.open(twin).await;
            let ended = carry_out(&bench, &*axis, *step, fault).await;
            let mut check = |right: bool, what: &str| {
                if !right {
                    let truth = bench.truth();
                    wrong.push(format!(
                        "{}, {step:?}, {fault}: {what}: {ended:?}, truly {truth:?}",
                        twin.driver
                    ));
                }
            };
            let (steps, moving) = bench.truth();
            match (&ended, end) {
                (Ok(found), Done | DoneOr(_)) => {
                    check(
                        (found.steps as f64 - steps).abs() <= 2.0,
                        "another position than the true one",
                    );
                    check(!moving && !found.moving, "still moving");
                    let target = match step {
                        Step::Move => Some(90.0),
                        Step::Position | Step::Home => Some(0.0),
                        Step::HomeTooSlow | Step::MoveTooSlow | Step::Stop => None,
                    };
                    let there = target.is_none_or(|deg| (found.place.value() - deg).abs() < 0.001);
                    check(there, "not where it belongs");
                }
                (Err(error), Stopped(kind) | DoneOr(kind)) => {
                    check(error.kind() == *kind, "another error");
                    check(!moving, "still moving");
                }
                (Err(error), Unknown(kind)) => check(error.kind() == *kind, "another error"),
                _ => check(false, "another end"),
            }
            // Afterwards the axis can be stopped, homed and moved by whoever opens it again.
            bench.room.order(&"clear axes".parse().unwrap());
            drop(axis);
            sleep(Duration::from_mins(1)).await;
            let axis = bench.open(twin).await;
            let moved = async {
                axis.stop().await?;
                axis.home(soon()).await?;
                axis.move_to(angle(-20.0)).await
            };
            let moved = moved.await;
            let there = moved
                .as_ref()
                .is_ok_and(|found| (found.place.value() + 20.0).abs() < 0.001);
            check(there, &format!("not taken up again: {moved:?}"));
        }
    }
    assert!(wrong.is_empty(), "{} of the table:\n{}", wrong.len(), wrong.join("\n"));
}
