//! The tutorial and the README, tried: every `$ isolux …` in a block ```` ```console ```` is run, and what the page
//! shows is what the program answers.
//!
//! A page runs in a folder of its own, from its first command to its last. A block ```` ```toml file=NAME ```` is a
//! file that the reader saves. In an answer a line `…` stands for any lines, a word `…` for any words, and within a
//! word for any letters; a number may differ by 2 %, for the pages say what a number means and not its last digit;
//! `(exit code N)` ends an answer. A command that ends in `&` runs until the page ends. Progress (standard error) comes
//! before the answer.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, ChildStdout};

use crate::folder::Folder;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

#[test]
fn a_day_on_the_virtual_bench_goes_as_the_book_says() {
    assert_eq!(tried("docs/src/tutorial-day.md"), 7);
}

#[test]
fn your_own_bench_goes_as_the_book_says() {
    assert_eq!(tried("docs/src/tutorial-bench.md"), 14);
}

#[test]
fn a_disagreement_and_its_cause_goes_as_the_book_says() {
    assert_eq!(tried("docs/src/tutorial-disagreement.md"), 3);
}

#[test]
fn a_second_day_goes_as_the_book_says() {
    assert_eq!(tried("docs/src/tutorial-second-day.md"), 6);
}

#[test]
fn the_readme_says_what_the_program_says() {
    assert_eq!(tried("README.md"), 2);
}

/// Runs a page; how many commands of `isolux` it has.
fn tried(page: &str) -> usize {
    let text = std::fs::read_to_string(Path::new(ROOT).join(page)).unwrap();
    let folder = Folder::in_memory();
    let example = folder.path("examples/hidden-effect");
    std::fs::create_dir_all(&example).unwrap();
    for file in std::fs::read_dir(Path::new(ROOT).join("examples/hidden-effect")).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), example.join(file.file_name())).unwrap();
    }
    let mut reader = Reader {
        page,
        folder,
        at: String::new(),
        beside: Vec::new(),
        commands: 0,
    };
    for (language, block) in blocks(&text) {
        if let Some(name) = language.strip_prefix("toml file=") {
            reader.folder.write(name, &block);
        } else if language == "console" {
            let (before, steps) = block.split_once("$ ").unwrap_or((&block, ""));
            assert_eq!(before, "", "{page}: an answer before the first command");
            for step in steps.split("\n$ ") {
                let (command, answer) = step.split_once('\n').unwrap_or((step, ""));
                reader.does(command, answer);
            }
        }
    }
    reader.commands
}

/// Somebody who follows a page.
struct Reader<'a> {
    page: &'a str,
    folder: Folder,
    /// The folder where the reader is, within `folder`.
    at: String,
    /// Programs that run until the page ends.
    beside: Vec<Beside>,
    commands: usize,
}

impl Reader<'_> {
    fn does(&mut self, command: &str, answer: &str) {
        let words: Vec<&str> = command.split_whitespace().collect();
        match words.as_slice() {
            ["cd", place] => (*place).clone_into(&mut self.at),
            [program, arguments @ .., "&"] if program.ends_with("isolux") => {
                self.commands += 1;
                let mut child = self.folder.start(arguments);
                let stated = BufReader::new(child.stdout.take().unwrap());
                let mut beside = Beside { child, stated };
                let lines: Vec<String> =
                    (answer.lines().filter(|line| !line.is_empty()).map(|_| beside.line())).collect();
                self.compare(command, answer, &lines.join("\n"));
                self.beside.push(beside);
            }
            [program, arguments @ ..] if program.ends_with("isolux") => {
                self.commands += 1;
                let mut command_line = self.folder.command(arguments);
                let output = command_line.current_dir(self.folder.path(&self.at)).output().unwrap();
                let stated = [output.stderr, output.stdout]
                    .map(|bytes| String::from_utf8(bytes).unwrap())
                    .concat();
                let (answer, exit) = match answer
                    .trim_end()
                    .strip_suffix(')')
                    .and_then(|text| text.rsplit_once("(exit code "))
                {
                    Some((answer, exit)) => (answer, exit.parse().unwrap()),
                    None => (answer, 0),
                };
                assert_eq!(output.status.code(), Some(exit), "{}: {command}\n{stated}", self.page);
                self.compare(command, answer, &stated);
            }
            // What a reader of the README builds, the tests have built already.
            ["cargo", ..] => {}
            _ => panic!("{}: nobody tries `{command}`", self.page),
        }
    }

    fn compare(&self, command: &str, answer: &str, stated: &str) {
        let shown: Vec<&str> = answer.lines().filter(|line| !line.is_empty()).collect();
        let lines: Vec<&str> = stated.lines().filter(|line| !line.is_empty()).collect();
        assert!(
            agree(&shown, &lines, "…", &|shown, line| {
                let [shown, line] = [shown, line].map(|text| text.split_whitespace().collect::<Vec<_>>());
                agree(&shown, &line, "…", &same_word)
            }),
            "{}: {command}\nthe page shows\n{answer}\nthe program says\n{stated}",
            self.page
        );
    }
}

/// A program that is killed with the page.
struct Beside {
    child: Child,
    stated: BufReader<ChildStdout>,
}

impl Beside {
    fn line(&mut self) -> String {
        let mut line = String::new();
        self.stated.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whether the shown pieces are the said ones, where `any` stands for any number of them.
fn agree(shown: &[&str], stated: &[&str], any: &str, same: &dyn Fn(&str, &str) -> bool) -> bool {
    match shown.split_first() {
        None => stated.is_empty(),
        Some((first, rest)) if *first == any => (0..=stated.len()).any(|from| agree(rest, &stated[from..], any, same)),
        Some((first, rest)) => stated
            .split_first()
            .is_some_and(|(word, others)| same(first, word) && agree(rest, others, any, same)),
    }
}

/// Words are equal, but for what `…` stands for; numbers, with what stands about them, within 2 %.
fn same_word(shown: &str, stated: &str) -> bool {
    if let Some((before, after)) = shown.split_once('…') {
        return stated.starts_with(before) && stated.ends_with(after);
    }
    let number = |word: &str| {
        let digits = word.trim_matches(|letter: char| !letter.is_ascii_digit() && letter != '-');
        digits
            .parse::<f64>()
            .ok()
            .map(|value| (value, word.replacen(digits, "", 1)))
    };
    match (number(shown), number(stated)) {
        (Some((a, around_a)), Some((b, around_b))) => around_a == around_b && (a - b).abs() <= 0.02 * a.abs(),
        _ => shown == stated,
    }
}

/// The fenced blocks of a page: what stands behind the fence, and their lines.
fn blocks(text: &str) -> Vec<(String, String)> {
    let mut blocks: Vec<(String, String)> = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        if let Some(language) = line.strip_prefix("```") {
            inside = !inside;
            if inside {
                blocks.push((language.to_owned(), String::new()));
            }
        } else if inside && let Some((_, block)) = blocks.last_mut() {
            block.push_str(line);
            block.push('\n');
        }
    }
    blocks
}
