//! `isolux init`.

use std::io::{IsTerminal as _, Write as _};

use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use isolux_app::files::Overwrite;
use isolux_app::init::Part;
use isolux_app::init::subject::Subject;
use isolux_app::instruments::devices;
use isolux_app::{Failure, init};

use super::twins::Played;
use crate::screen;

/// A station, plan, scene and job file to start from, commented; they run as they are, in the virtual darkroom.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  isolux init bench && isolux scan bench/station.toml bench/plan.toml --out bench/run\n  \
isolux init bench --luminaire maker=ACME --luminaire name=\"Spot 12\" --report laboratory=\"Lab, Town\"\n  \
isolux init spot --lamp SPOT.ldt   room, station and plan for that luminaire: its scan rehearsed\n  \
isolux init spot --lamp SPOT.ldt --sweep   the same, read while γ moves\n  \
isolux init bench --colour         with spectra over angle: the colour of every direction\n  \
isolux init lab --standard        a bench under a standard lamp with its certificate, to calibrate\n  \
isolux init --room room.toml      the whole built-in virtual darkroom, every key of it, to change\n  \
isolux init --bench bench.toml    a bench of your own: asks which instruments and ports there are\n  \
isolux init --bench bench.toml --open axis.c=zaber:/dev/ttyUSB0?axis=1 --open lamp=hand\n\
Parts of a bench: axis.c, axis.gamma, luxmeter, spectroradiometer, powermeter, supply, lamp, shutter, baffle, rail, ambient. What is not named \
stays a twin, and powermeter and supply absent; \
`hand` is a person, `none` is absent. `isolux devices` lists drivers and ports.\n\
A room file may leave keys out: those are the built-in room's, and the commands that read it say which."
)]
pub struct Init {
    /// The folder to write into.
    #[arg(required_unless_present_any = ["room", "bench"])]
    folder: Option<Utf8PathBuf>,
    /// Write the whole built-in virtual darkroom to FILE (`-` prints it).
    #[arg(long, value_name = "FILE")]
    room: Option<Utf8PathBuf>,
    /// Write a station file for a bench of instruments, one after the other, and twins for the rest.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["folder", "room", "plan", "axes", "luxmeter", "spectroradiometer", "powermeter", "supply"])]
    bench: Option<Utf8PathBuf>,
    /// A part of that bench; without any, they are asked for.
    #[arg(long, value_name = "PART=DRIVER:TARGET", requires = "bench")]
    open: Vec<String>,
    /// Plan of the day: at the distance that `isolux plan` proposes, or the published one at 10 m.
    #[arg(long, default_value = "near", value_parser = ["near", "published-10m"])]
    plan: String,
    /// Write them for the luminaire of a photometric file (.ldt, .ies, …): a virtual room with that lamp, and a plan
    /// for its symmetry and beam.
    #[arg(long, value_name = "FILE", requires = "folder", conflicts_with_all = ["room", "plan"])]
    lamp: Option<Utf8PathBuf>,
    /// Write a virtual bench under a standard lamp, and the certificate of that lamp, for `isolux calibrate`.
    #[arg(long, requires = "folder",
        conflicts_with_all = ["room", "plan", "lamp", "sweep", "colour", "luminaire", "report", "ask"])]
    standard: bool,
    /// Read the distribution while γ moves: minutes from a stable lamp in place of hours. Instruments that are not
    /// named are those that can.
    #[arg(long, requires = "folder")]
    sweep: bool,
    /// Take spectra over angle too, C0 and C90 by 10°: the colour of every direction and of the whole light.
    #[arg(long, requires = "folder")]
    colour: bool,
    /// What the job says of the luminaire: maker, name, catalogue_number, sample, light_source, driver,
    /// burning_position, hours_run.
    #[arg(long, value_name = "KEY=TEXT", requires = "folder")]
    luminaire: Vec<String>,
    /// What the job says of the report: number, laboratory, operator, approved_by, customer, received, method, notes.
    #[arg(long, value_name = "KEY=TEXT", requires = "folder")]
    report: Vec<String>,
    /// Ask for them, one after the other.
    #[arg(long, requires = "folder", conflicts_with_all = ["luminaire", "report"])]
    ask: bool,
    /// Print the names as JSON.
    #[arg(long, conflicts_with = "room")]
    json: bool,
    /// Replace files that exist.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    played: Played,
}

/// Runs the command.
pub fn run(arguments: &Init) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.force);
    if let Some(file) = &arguments.bench {
        isolux_app::files::refuse_existing(file, overwrite)?;
        let parts = match arguments.open.as_slice() {
            [] => requested(file)?,
            named => named
                .iter()
                .map(|text| named_part(text, file))
                .collect::<Result<_, _>>()?,
        };
        return described(&init::bench(file, &parts, overwrite)?, arguments.json);
    }
    let room = arguments.room.as_ref().filter(|room| *room != "-");
    if let Some(room) = room {
        // Before the folder's files are written: all of them or none.
        isolux_app::files::refuse_existing(room, overwrite)?;
    }
    let subject = if arguments.ask {
        asked_subject()?
    } else {
        init::subject::stated(&arguments.luminaire, &arguments.report)?
    };
    let instruments = init::Instruments {
        in_motion: arguments.sweep,
        colour: arguments.colour,
        ..arguments.played.instruments()
    };
    let mut written = match (&arguments.folder, &arguments.lamp) {
        (Some(folder), _) if arguments.standard => init::with_standard(folder, &instruments, overwrite)?,
        (Some(folder), Some(lamp)) => {
            let bars = screen::Bars::default();
            init::for_lamp(folder, lamp, &instruments, &subject, overwrite, &bars)?
        }
        (Some(folder), None) => {
            let plan = init::DayPlan::named(&arguments.plan).unwrap_or_default();
            init::run(folder, plan, &instruments, &subject, overwrite)?
        }
        (None, _) => Vec::new(),
    };
    match (room, &arguments.room) {
        (Some(room), _) => {
            init::room(room, overwrite)?;
            written.push(room.clone());
        }
        (None, Some(_)) => screen::say(init::ROOM.trim_end())?,
        (None, None) => {}
    }
    described(&written, arguments.json)
}

fn described(written: &[Utf8PathBuf], json: bool) -> Result<(), Failure> {
    if json {
        return screen::say(serde_json::json!({ "written": written }));
    }
    written.iter().try_for_each(screen::say)
}

/// `PART=DRIVER:TARGET`.
fn named_part(text: &str, file: &Utf8Path) -> Result<Part, Failure> {
    match text.split_once('=') {
        Some((name, open)) => init::part(name, open, file),
        None => Err(Failure::bad_input(format!("--open {text} is not PART=DRIVER:TARGET"))),
    }
}

/// Asks for one part after the other what it is; an empty answer leaves the twin.
fn requested(file: &Utf8Path) -> Result<Vec<Part>, Failure> {
    if !std::io::stdin().is_terminal() {
        return Err(Failure::bad_input("--bench asks on a terminal, and this is none")
            .help("name the parts, as --open axis.c=zaber:/dev/ttyUSB0?axis=1"));
    }
    let found = devices::devices()?;
    screen::say("Empty: a twin for now (powermeter, supply: none). hand: a person does it. none: the bench has none.")?;
    for port in &found.ports {
        let missing = port
            .missing
            .as_ref()
            .map_or(String::new(), |missing| format!(" ({missing})"));
        screen::say(format_args!("  port {} {}{missing}", port.path, port.description))?;
    }
    let mut parts = Vec::new();
    for (name, kind, _) in init::PARTS {
        for driver in &found.drivers {
            if let Some(place) = driver.kinds.iter().position(|known| *known == kind.name()) {
                screen::say(format_args!("  {}", driver.examples[place]))?;
            }
        }
        loop {
            prompt(name)?;
            let mut line = String::new();
            let read = std::io::stdin().read_line(&mut line).map_err(Failure::bad_input)?;
            match line.trim() {
                _ if read == 0 => return Err(Failure::bad_input("the questions were broken off; nothing was written")),
                "" => break,
                open => match init::part(name, open, file) {
                    Ok(part) => {
                        parts.push(part);
                        break;
                    }
                    Err(failure) => screen::say(failure.message)?,
                },
            }
        }
    }
    Ok(parts)
}

/// Asks for what is measured and for whom; an empty answer leaves a key out.
fn asked_subject() -> Result<Subject, Failure> {
    if !std::io::stdin().is_terminal() {
        return Err(Failure::bad_input("--ask asks on a terminal, and this is none")
            .help("give the texts, as --luminaire maker=ACME --report customer=B"));
    }
    screen::say("Empty: not known.")?;
    let mut stated = [Vec::new(), Vec::new()];
    for ((_, keys), stated) in init::subject::TABLES.into_iter().zip(&mut stated) {
        for key in keys {
            loop {
                prompt(key.what)?;
                let mut line = String::new();
                let read = std::io::stdin().read_line(&mut line).map_err(Failure::bad_input)?;
                let text = line.trim();
                if read == 0 {
                    return Err(Failure::bad_input("the questions were broken off; nothing was written"));
                }
                if text.is_empty() {
                    break;
                }
                match key.check(text) {
                    Ok(()) => {
                        stated.push(format!("{}={text}", key.name));
                        break;
                    }
                    Err(why) => screen::say(why)?,
                }
            }
        }
    }
    let [luminaire, report] = stated;
    init::subject::stated(&luminaire, &report)
}

fn prompt(name: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout();
    write!(out, "{name}: ")
        .and_then(|()| out.flush())
        .map_err(Failure::instrument)
}
