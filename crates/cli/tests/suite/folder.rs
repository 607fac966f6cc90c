//! A folder of its own for one test, and the program run in it.

use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

/// Removed when the test ends; kept below `ISOLUX_TEST_DIR` where that is set.
pub struct Folder {
    directory: tempfile::TempDir,
    low_priority: bool,
}

impl Folder {
    #[allow(dead_code, reason = "not every test that has this module is content with a disk")]
    pub fn new() -> Self {
        Self::below(std::env::temp_dir())
    }

    /// Every reading is synced to the disk before the next move; a folder in memory spares minutes of that.
    pub fn in_memory() -> Self {
        let memory = PathBuf::from("/dev/shm");
        Self::below(if memory.is_dir() { memory } else { std::env::temp_dir() })
    }

    fn below(place: PathBuf) -> Self {
        let kept = std::env::var_os("ISOLUX_TEST_DIR").map(PathBuf::from);
        let mut directory = tempfile::tempdir_in(kept.as_deref().unwrap_or(&place)).unwrap();
        directory.disable_cleanup(kept.is_some());
        Self {
            directory,
            low_priority: false,
        }
    }

    /// The program runs here at the lowest priority, so that it delays nothing that is timed beside it.
    #[allow(
        dead_code,
        reason = "not every test that has this module runs beside others that are timed"
    )]
    pub fn at_low_priority(self) -> Self {
        // Windows has no `nice`, and there nothing runs beside that is timed.
        Self {
            low_priority: cfg!(unix),
            ..self
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    #[allow(dead_code, reason = "not every test that has this module reads documents")]
    pub fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// The program with nobody at its keyboard.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let isolux = env!("CARGO_BIN_EXE_isolux");
        let mut command = Command::new(if self.low_priority { "nice" } else { isolux });
        if self.low_priority {
            command.args(["-n", "19", isolux]);
        }
        command
            .args(arguments)
            .current_dir(self.directory.path())
            .stdin(Stdio::null());
        command
    }

    pub fn start(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Runs the program to its end, asserts its exit code and gives what it said to the pipe and to the person.
    pub fn isolux(&self, arguments: &[&str], exit: i32) -> String {
        stated(self.start(arguments).wait_with_output().unwrap(), Some(exit))
    }
}

/// What the program said to the pipe and to the person, after its exit code was asserted; no code after a signal.
pub fn stated(output: Output, exit: Option<i32>) -> String {
    let Output { status, stdout, stderr } = output;
    let [stdout, stderr] = [stdout, stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert_eq!(status.code(), exit, "{stdout}{stderr}");
    stdout + &stderr
}
