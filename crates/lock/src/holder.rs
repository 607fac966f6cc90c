//! Who holds a lock, and what has become of that process.

use std::fmt;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::system::{self, host};

/// First line of a lock file.
pub(crate) const FORMAT_LINE: &str = "format = \"isolux-lock/1\"\n";

/// A process that holds a lock, as its lock file names it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    /// Number of the process.
    pub pid: u32,
    /// Name of the computer that it runs on.
    pub host: String,
    /// Its command line.
    pub command: String,
    /// When it took the lock, seconds after 1970-01-01T00:00:00Z.
    pub since_unix_s: u64,
    /// When it started, in the clock ticks of its computer: a later process with the same number differs here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub process_start: Option<u64>,
}

/// What has become of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProcessState {
    /// It runs, or waits for something.
    Runs,
    /// It was stopped by a signal and does nothing until it is continued.
    Stopped,
    /// It has ended.
    Gone,
    /// It runs on another computer, or this system does not say.
    Unknown,
}

impl Holder {
    /// This process, from now on.
    pub fn this_process() -> Self {
        let command: Vec<String> = std::env::args_os()
            .map(|argument| argument.to_string_lossy().into_owned())
            .collect();
        Self {
            pid: std::process::id(),
            host: host(),
            command: command.join(" "),
            since_unix_s: SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .map_or(0, |since| since.as_secs()),
            process_start: stat(std::process::id()).map(|(_, start)| start),
        }
    }

    /// What has become of it.
    pub fn state(&self) -> ProcessState {
        if self.host != host() {
            return ProcessState::Unknown;
        }
        match (stat(self.pid), self.process_start) {
            (Some((_, now)), Some(then)) if now != then => ProcessState::Gone,
            (Some(('Z' | 'X', _)), _) | (None, Some(_)) => ProcessState::Gone,
            (Some(('T' | 't', _)), _) => ProcessState::Stopped,
            (Some(_), _) => ProcessState::Runs,
            (None, None) => ProcessState::Unknown,
        }
    }

    /// Asks it to end, as Ctrl-C would (SIGTERM). Nothing is sent unless it is certain that the number still belongs to
    /// that process.
    ///
    /// # Errors
    /// Why nothing was sent, or what the system said.
    pub fn ask_to_end(&self) -> Result<(), String> {
        if self.process_start.is_none() || !matches!(self.state(), ProcessState::Runs | ProcessState::Stopped) {
            return Err("this computer does not know that process".to_owned());
        }
        system::ask_to_end(self.pid)
    }

    pub(crate) fn to_text(&self) -> String {
        // A struct of numbers and strings is always a TOML table.
        format!("{FORMAT_LINE}{}", toml::to_string(self).unwrap_or_default())
    }

    pub(crate) fn parse(text: &str) -> Option<Self> {
        toml::from_str(text.strip_prefix(FORMAT_LINE)?).ok()
    }
}

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` (pid {}", self.command, self.pid)?;
        if self.host != host() {
            write!(f, " on {}", self.host)?;
        }
        match jiff::Timestamp::from_second(self.since_unix_s.try_into().unwrap_or(i64::MAX)) {
            Ok(since) => write!(f, ", since {since})"),
            Err(_) => f.write_str(")"),
        }
    }
}

/// State letter and start of a process, from `/proc` (proc_pid_stat(5), fields 3 and 22); none where there is no such
/// process or no `/proc`.
fn stat(pid: u32) -> Option<(char, u64)> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name before it is in parentheses and may hold spaces and parentheses itself.
    let (_, fields) = text.rsplit_once(") ")?;
    let mut fields = fields.split_ascii_whitespace();
    let state = fields.next()?.chars().next()?;
    Some((state, fields.nth(18)?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_damage_is_none() {
        let holder = Holder {
            command: "isolux scan \"my station\".toml\nplan".to_owned(),
            ..Holder::this_process()
        };
        let text = holder.to_text();
        assert_eq!(Holder::parse(&text), Some(holder));
        for end in 0..FORMAT_LINE.len() + 5 {
            assert_eq!(Holder::parse(&text[..end]), None);
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_process_that_has_ended_is_gone_and_a_number_that_was_used_again_is_not_it() {
        let us = Holder::this_process();
        assert_eq!(us.state(), ProcessState::Runs);
        let earlier = Holder {
            process_start: us.process_start.map(|start| start - 1),
            ..us.clone()
        };
        assert_eq!(earlier.state(), ProcessState::Gone);
        assert!(
            earlier.ask_to_end().is_err(),
            "a process that is not meant gets no signal"
        );
        let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
        let other = Holder {
            pid: child.id(),
            process_start: stat(child.id()).map(|(_, start)| start),
            ..us.clone()
        };
        assert_eq!(other.state(), ProcessState::Runs);
        other.ask_to_end().unwrap();
        child.wait().unwrap();
        assert_eq!(other.state(), ProcessState::Gone);
        let elsewhere = Holder {
            host: "another computer".to_owned(),
            ..us
        };
        assert_eq!(elsewhere.state(), ProcessState::Unknown);
        assert!(elsewhere.to_string().contains("on another computer"));
    }
}
