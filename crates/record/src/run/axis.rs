//! One axis of time over all sessions of a run: seconds since it began.

use super::header::RunHeader;
use crate::readings::Readings;

/// Places rows that have the time since the lamp was switched on alone, one after the other in the order in which they
/// were taken.
#[derive(Debug, Default)]
pub(crate) struct Axis {
    /// Time of the row before.
    time_s: f64,
    /// When the lamp of that row was switched on.
    on_s: f64,
    /// Its burning and its time since the lamp was switched on.
    before: Option<(Option<u32>, f64)>,
}

impl Axis {
    /// The time of the next row, of a session that began at `began_s`. A burning begins with another number or where the
    /// clock of the lamp goes back: at `on_s` where that is known, else as soon after the row before as it can have been.
    pub(crate) fn next(&mut self, burning: Option<u32>, lamp_s: Option<f64>, began_s: f64, on_s: Option<f64>) -> f64 {
        let earliest_s = self.time_s.max(began_s);
        let clock_s = lamp_s.unwrap_or(f64::NEG_INFINITY);
        if self
            .before
            .is_none_or(|(before, last_s)| before != burning || clock_s < last_s)
        {
            self.on_s = on_s.filter(|on_s| *on_s >= earliest_s).unwrap_or(earliest_s);
        }
        self.before = Some((burning, clock_s));
        let time_s = lamp_s.map_or(earliest_s, |lamp_s| earliest_s.max(self.on_s + lamp_s));
        self.time_s = (time_s * 1e6).round() / 1e6;
        self.time_s
    }
}

/// Places the rows of format 3 on the axis of the run. A session begins at its UTC, or where the clock of the
/// computer says that this was before the last row, directly after that. The last switching on of the lamp is known by
/// its UTC.
pub(super) fn place(header: &RunHeader, readings: &mut Readings) {
    if readings.layout.has_run_time() {
        return;
    }
    let later = header.resumed.iter();
    let later = later.map(|session| header.seconds(&session.utc).unwrap_or(0.0));
    let began_s: Vec<f64> = std::iter::once(0.0).chain(later).collect();
    let last_on_s = header.lamp_on_utc.as_deref().and_then(|utc| header.seconds(utc));
    let mut axis = Axis::default();
    for row in &mut readings.rows {
        let began_s = began_s.get(row.session as usize).copied().unwrap_or(0.0);
        let on_s = last_on_s.filter(|_| row.burning == Some(header.burnings));
        row.time_s = Some(axis.next(row.burning, row.lamp_s, began_s, on_s));
    }
}
