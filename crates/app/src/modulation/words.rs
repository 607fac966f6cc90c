//! An evaluation in words.

use isolux_report::day::modulation_facts;

use super::Evaluated;

impl Evaluated {
    /// What it says, a line each.
    pub fn stated(&self) -> Vec<String> {
        let mut lines = vec![self.waveform.clone()];
        lines.extend(
            modulation_facts(&self.modulation)
                .into_iter()
                .map(|(name, value)| format!("  {name:24} {value}")),
        );
        lines.extend(self.modulation.notes.iter().map(|note| format!("  note: {note}")));
        for verdict in &self.verdicts {
            let passes = if verdict.passes { "passes" } else { "FAILS" };
            let doubt = match verdict.beyond_doubt {
                Some(true) => "",
                Some(false) => ", within its uncertainty",
                None => ", its uncertainty is not known",
            };
            lines.push(format!("{} ≤ {}: {passes}{doubt}", verdict.quantity, verdict.limit));
        }
        lines
    }
}
