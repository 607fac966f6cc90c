//! The person at the terminal: answers what a scan asks, and pauses it.

use std::io::{BufRead as _, IsTerminal as _, Write as _};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

use isolux_app::front_end::control::{Control, Pace, Pause};
use isolux_app::front_end::operator::ByFunction;

/// Where the next line goes while a question is open.
type Question = Mutex<Option<Sender<String>>>;

/// One reader of standard input: a line is the answer to the question that is open, or else a command.
#[derive(Clone)]
pub struct Terminal {
    control: Control,
    /// None: nobody is at standard input.
    requested: Option<Arc<Question>>,
}

impl Terminal {
    /// The terminal at standard input, if there is one; from now on its lines are read here alone.
    pub fn of_stdin() -> Self {
        let mut control = Control::default();
        let requested: Option<Arc<Question>> = std::io::stdin().is_terminal().then(Arc::default);
        if let Some(requested) = requested.clone() {
            control.pace = Pace::Attended;
            let pause = control.pause.clone();
            // Ends with the program: a read of the terminal cannot be broken off.
            std::thread::spawn(move || read(&requested, &pause));
        }
        Self { control, requested }
    }

    /// The person who answers questions, if there is one.
    pub fn operator(&self) -> Option<ByFunction> {
        let requested = self.requested.clone()?;
        Some(ByFunction::new(move |prompt| ask(prompt, &requested)))
    }

    /// What a scan listens to: `p` pauses and goes on.
    pub fn control(&self) -> Control {
        self.control.clone()
    }

    /// The next line, after these words.
    ///
    /// # Errors
    /// Why there is none.
    pub fn line(&self, words: &str) -> Result<String, String> {
        match &self.requested {
            Some(requested) => line(words, requested),
            None => Err("nobody is at the terminal".to_owned()),
        }
    }
}

/// Reads lines for ever.
fn read(requested: &Question, pause: &Pause) {
    for line in std::io::stdin().lock().lines() {
        let Ok(line) = line else { break };
        let open = requested.lock().unwrap_or_else(PoisonError::into_inner).take();
        match open {
            // Whoever asked may have been interrupted meanwhile.
            Some(answer) => drop(answer.send(line)),
            None => command(line.trim(), pause),
        }
    }
    // Whoever waits for an answer must not wait for ever.
    *requested.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

fn command(line: &str, pause: &Pause) {
    let stated = match line {
        "p" | "P" if pause.toggle("the terminal") => {
            "pause: after the point that is being read; the axes are stopped, the lamp stays on. `p` and Enter goes on"
        }
        "p" | "P" => "goes on: first the reference point",
        "" => return,
        _ => "`p` and Enter pauses and goes on, Ctrl-C ends the scan",
    };
    let _ = writeln!(std::io::stderr().lock(), "{:>12}  {stated}", "note");
}

fn ask(prompt: &str, requested: &Question) -> Result<String, String> {
    let answer = line(&format!("\n{prompt}\nDone? Your name (empty: not done): "), requested)?;
    match answer.trim() {
        "" => Err("the answer was empty".to_owned()),
        who => Ok(who.to_owned()),
    }
}

fn line(words: &str, requested: &Question) -> Result<String, String> {
    let (answer, wait) = channel();
    *requested.lock().unwrap_or_else(PoisonError::into_inner) = Some(answer);
    let mut stderr = std::io::stderr().lock();
    let _ = stderr.write_all(words.as_bytes());
    let _ = stderr.flush();
    drop(stderr);
    wait.recv().map_err(|_| "standard input was closed".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p_pauses_and_goes_on_and_nothing_else_does() {
        let pause = Pause::new();
        for (line, paused) in [("", false), ("x", false), ("p", true), ("pp", true), ("P", false)] {
            command(line, &pause);
            assert_eq!(pause.requested().is_some(), paused, "`{line}`");
        }
    }

    #[test]
    fn a_line_is_the_answer_to_the_open_question() {
        let requested: Arc<Question> = Arc::default();
        for (line, expected) in [(" Ada ", Ok("Ada")), ("", Err("the answer was empty"))] {
            let lines = requested.clone();
            let reader = std::thread::spawn(move || {
                loop {
                    if let Some(answer) = lines.lock().unwrap().take() {
                        return answer.send(line.to_owned()).unwrap();
                    }
                    std::thread::yield_now();
                }
            });
            let answer = ask("cap the detector", &requested);
            assert_eq!(answer.as_deref().map_err(String::as_str), expected);
            reader.join().unwrap();
        }
    }
}
