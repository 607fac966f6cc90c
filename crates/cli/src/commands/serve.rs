//! `isolux serve`, and the page beside a scan.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};

use camino::{Utf8Path, Utf8PathBuf};
use clap::Args;
use isolux_app::Failure;
use isolux_app::front_end::control::{Control, Pace};
use isolux_app::front_end::progress::Progress;
use isolux_page::{Page, Place};

use crate::screen::{self, Bars};

/// Serve the local page: start, watch, pause and end scans, and see their results, in the browser.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux serve bench\n\
The page is for this machine alone, and opens by the address that is printed, once; each further browser gets an address of its own.")]
pub struct Serve {
    /// The folder of jobs and runs.
    #[arg(default_value = ".")]
    folder: Utf8PathBuf,
    #[command(flatten)]
    address: Address,
    /// Print the address only; start no browser.
    #[arg(long)]
    no_browser: bool,
}

/// Where the page is served.
#[derive(Debug, Args)]
pub struct Address {
    /// Address of the page.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    listen: IpAddr,
    /// Port of the page; 0 for a free one.
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// With an address that other machines can reach: whoever has the page's code may then drive the axes, unencrypted.
    #[arg(long)]
    others_may_drive_the_axes: bool,
    /// A virtual bench runs so many times faster than real time while a page shows it.
    #[arg(long, value_name = "TIMES", default_value_t = 300.0, value_parser = times)]
    speed: f64,
}

impl Address {
    /// The pace of a virtual bench under the page.
    pub const fn pace(&self) -> Pace {
        Pace::Times(self.speed)
    }

    const fn place<'a>(&self, folder: &'a Utf8Path) -> Place<'a> {
        Place {
            listen: SocketAddr::new(self.listen, self.port),
            others_may_drive: self.others_may_drive_the_axes,
            folder,
            pace: self.pace(),
        }
    }
}

fn times(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(times) if (1.0..=1e5).contains(&times) => Ok(times),
        _ => Err(format!("`{text}`: expected 1 (real time) to 100000")),
    }
}

/// Runs the command.
pub fn run(arguments: &Serve) -> Result<(), Failure> {
    if !arguments.folder.is_dir() {
        return Err(Failure::bad_input(format!("{} is no folder", arguments.folder)));
    }
    let place = arguments.address.place(&arguments.folder);
    isolux_page::serve(&place, &Bars::default(), note, |page| {
        opened(page, !arguments.no_browser)
    })
}

/// Carries out a scan beside a page that shows and commands it, and stays until nobody looks at the page any more.
///
/// # Errors
/// Those of the page and of `work`.
pub fn beside<T>(
    address: &Address,
    folder: &Utf8Path,
    control: &Control,
    work: impl FnOnce(&dyn Progress) -> Result<T, Failure>,
) -> Result<(T, Page), Failure> {
    let page = Page::beside_a_scan(&address.place(folder), note)?;
    opened(&page, true)?;
    let done = page.show(control, &Bars::default(), work)?;
    Ok((done, page))
}

fn opened(page: &Page, browser: bool) -> Result<(), Failure> {
    screen::say(format_args!("page                  {}", page.url()))?;
    if browser && !page.open() {
        screen::say("(no browser could be started; open the address by hand)")?;
    }
    Ok(())
}

fn note(words: &str) {
    use std::io::Write as _;
    let _ = writeln!(std::io::stderr().lock(), "{:>12}  {words}", "note");
}
