//! `isolux verify`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::verify::{self, FileVerdict, State, Verification, VerifyRequest};

use crate::screen;

/// Says whether a run still is what was recorded, and its results what this program computes from it.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  isolux verify run\n  isolux verify run --sign --key lab.key\n  \
isolux verify run --public-key lab.pub\n\
Every file is compared with its checksum and every result with what is computed again from the record. A file \
for which nothing speaks is listed as not checked; a signature covers all of them. \
Keys and signatures are those of minisign: `minisign -G -s lab.key -p lab.pub` makes them, \
`minisign -V -m run/SHA256SUMS -p lab.pub` checks.\n\
Exit 1 when a file differs, or the signature is not of this run or not by that key; nothing is signed then."
)]
pub struct Verify {
    /// The run directory.
    run: Utf8PathBuf,
    /// Check the signature of the run with this public key of minisign.
    #[arg(long, value_name = "KEY.pub", conflicts_with = "sign")]
    public_key: Option<Utf8PathBuf>,
    /// Sign the run where nothing differs: writes SHA256SUMS and SHA256SUMS.minisig into it.
    #[arg(long, requires = "key")]
    sign: bool,
    /// The secret key of minisign to sign with.
    #[arg(long, value_name = "FILE", requires = "sign")]
    key: Option<Utf8PathBuf>,
    /// Compare this station file, and the calibration that it names, with those of the run too.
    #[arg(long, value_name = "STATION.toml")]
    station: Option<Utf8PathBuf>,
    /// Every file by its name.
    #[arg(long)]
    all: bool,
    /// Print what was found as JSON.
    #[arg(long)]
    json: bool,
    /// Replace a signature that exists.
    #[arg(long, requires = "sign")]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Verify) -> Result<(), Failure> {
    let request = VerifyRequest {
        run: &arguments.run,
        public_key: arguments.public_key.as_deref(),
        station: arguments.station.as_deref(),
    };
    let progress = screen::Bars::default();
    let (found, signature) = match &arguments.key {
        Some(key) => {
            let overwrite = Overwrite::requested(arguments.force);
            let (found, target) = verify::sign(&request, key, &password, overwrite, &progress)?;
            (found, Some(target))
        }
        None => (verify::run(&request, &progress)?, None),
    };
    if arguments.json {
        screen::say(serde_json::to_string_pretty(&found).map_err(Failure::instrument)?)?;
    } else {
        tell(&found, arguments.all)?;
    }
    let differ: Vec<&str> = found.of(State::Differs).map(|file| file.name.as_str()).collect();
    if !differ.is_empty() {
        let and = if signature.is_some() {
            "; nothing was signed"
        } else {
            ""
        };
        return Err(Failure::no(format!(
            "{}: {} of {} files differ: {}{and}",
            found.run,
            differ.len(),
            found.files.len(),
            differ.join(", ")
        ))
        .help("restore what was changed from a copy; results can be made again with `isolux reduce RUN --force`"));
    }
    match signature {
        Some(target) if !arguments.json => screen::say(format_args!("signed        {target}")),
        _ => Ok(()),
    }
}

/// Asks for the password of a key at the terminal.
fn password() -> Result<String, Failure> {
    rpassword::prompt_password("password of the key: ").map_err(|error| {
        Failure::bad_input(format!("the key has a password, and it cannot be asked for: {error}"))
            .help("run this at a terminal, or give a key without a password (`minisign -G -W`)")
    })
}

/// What was found: what agrees in groups, what was not checked and what differs file by file.
fn tell(found: &Verification, all: bool) -> Result<(), Failure> {
    screen::say(format_args!("run           {}", found.run))?;
    screen::say(format_args!("verified by   {}", found.verified_by))?;
    if let Some(program) = &found.recorded_by {
        screen::say(format_args!("recorded by   {program}"))?;
    }
    for program in &found.reduced_by {
        screen::say(format_args!("reduced by    {program}"))?;
    }
    if let Some(signed) = &found.signature {
        let comment = signed.comment.replace('\t', ", ");
        let state = if signed.by_this_key { "valid" } else { "not confirmed" };
        screen::say(format_args!("signature     {state}, key {}: {comment}", signed.key))?;
    }
    for (because, files) in groups(found.of(State::Agrees)) {
        screen::say(format_args!("agrees        {}: {because}", names(&files, all)))?;
    }
    for (because, files) in groups(found.of(State::NotChecked)) {
        screen::say(format_args!("NOT CHECKED   {}: {because}", names(&files, true)))?;
    }
    for file in found.of(State::Differs) {
        for difference in &file.differs {
            let line = difference.line.map_or_else(String::new, |line| format!(":{line}"));
            screen::say(format_args!("DIFFERS       {}{line}: {}", file.name, difference.what))?;
        }
    }
    for note in &found.notes {
        screen::say(format_args!("note          {note}"))?;
    }
    let count = |state| found.of(state).count();
    screen::say(format_args!(
        "{} files agree, {} were not checked, {} differ",
        count(State::Agrees),
        count(State::NotChecked),
        count(State::Differs)
    ))
}

/// Files for which the same is said, in the order of the first.
fn groups<'a>(files: impl Iterator<Item = &'a FileVerdict>) -> Vec<(String, Vec<&'a str>)> {
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for file in files {
        let because = file.because.join("; ");
        match groups.iter_mut().find(|(other, _)| *other == because) {
            Some((_, names)) => names.push(&file.name),
            None => groups.push((because, vec![&file.name])),
        }
    }
    groups
}

/// Names of a group; of many files their folders and how many, unless `all`.
fn names(files: &[&str], all: bool) -> String {
    const FEW: usize = 4;
    if all || files.len() <= FEW {
        return files.join(", ");
    }
    let mut folders: Vec<(&str, usize)> = Vec::new();
    for file in files {
        // A file of the run itself stands for itself.
        let folder = file.rsplit_once('/').map_or(*file, |(folder, _)| folder);
        match folders.iter_mut().find(|(other, _)| *other == folder) {
            Some((_, count)) => *count += 1,
            None => folders.push((folder, 1)),
        }
    }
    let words = folders.iter().map(|(folder, count)| match count {
        1 if files.contains(folder) => (*folder).to_owned(),
        1 => format!("{folder}/ (1 file)"),
        many => format!("{folder}/ ({many} files)"),
    });
    words.collect::<Vec<_>>().join(", ")
}
