//! One module a command: its arguments, its call, its words on the screen.

mod calibrate;
mod check;
mod compare;
mod convert;
mod devices;
mod diagnose;
mod flicker;
mod history;
mod init;
mod inspect;
mod investigate;
mod manual;
mod plan;
mod predict;
mod reading;
mod reduce;
mod report;
mod run;
mod scan;
mod serve;
mod simulate;
mod sweep;
mod takeover;
mod twins;
mod verify;

use clap::Subcommand;
use isolux_app::Failure;

/// Everything that `isolux` can be told to do, in the order of a day. One line a command here, one arm in [`run()`].
#[derive(Debug, Subcommand)]
pub enum Command {
    Run(run::Run),
    Init(init::Init),
    Devices(devices::Devices),
    Check(check::Check),
    Calibrate(calibrate::Calibrate),
    History(history::History),
    Home(manual::Home),
    Move(manual::Move),
    Switch(manual::Switch),
    Stop(manual::Stop),
    Read(manual::Read),
    Warmup(manual::Warmup),
    Plan(plan::Plan),
    Scan(scan::Scan),
    Reduce(reduce::Reduce),
    Convert(convert::Convert),
    Inspect(inspect::Inspect),
    Compare(compare::Compare),
    Flicker(flicker::Flicker),
    Investigate(investigate::Investigate),
    Simulate(simulate::Simulate),
    Sweep(sweep::Sweep),
    Merge(sweep::Merge),
    Predict(predict::Predict),
    Diagnose(diagnose::Diagnose),
    Report(report::Report),
    Verify(verify::Verify),
    Serve(serve::Serve),
    Virtual(twins::Virtual),
}

/// Runs one command to its end.
///
/// # Errors
/// What the use case answers; its kind is the exit code.
pub fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Init(arguments) => init::run(&arguments),
        Command::Devices(arguments) => devices::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::History(arguments) => history::run(&arguments),
        Command::Home(arguments) => manual::home(&arguments),
        Command::Move(arguments) => manual::move_to(&arguments),
        Command::Switch(arguments) => manual::switch(&arguments),
        Command::Stop(arguments) => manual::stop(&arguments),
        Command::Read(arguments) => manual::read(&arguments),
        Command::Warmup(arguments) => manual::warm_up(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Scan(arguments) => scan::run(&arguments),
        Command::Reduce(arguments) => reduce::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Flicker(arguments) => flicker::run(&arguments),
        Command::Investigate(arguments) => investigate::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
        Command::Merge(arguments) => sweep::merge(&arguments),
        Command::Predict(arguments) => predict::run(&arguments),
        Command::Diagnose(arguments) => diagnose::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Verify(arguments) => verify::run(&arguments),
        Command::Serve(arguments) => serve::run(&arguments),
        Command::Virtual(arguments) => twins::run(&arguments),
    }
}

/// A count as people write it: `2000`, `2e9`, `2_000_000`. At least 1.
pub(crate) fn count(text: &str) -> Result<u64, String> {
    let plain = text.replace('_', "");
    let value = plain.parse::<u64>().ok().or_else(|| {
        // Counts such as 2e9; beyond 2^53 a float would not hold every whole number.
        let value: f64 = plain.parse().ok()?;
        (value.fract() == 0.0 && (0.0..9.1e15).contains(&value)).then_some(value as u64)
    });
    match value {
        Some(0) => Err(format!("`{text}`: at least 1 is needed")),
        Some(value) => Ok(value),
        None => Err(format!("`{text}` is no whole number such as 2000, 2e9 or 2_000_000")),
    }
}
