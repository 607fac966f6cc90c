//! The dark of a lux meter that needs one, before its first reading.

use isolux_record::plan::Block;

use super::session::Session;
use crate::dark;
use crate::error::ScanError;

impl Session<'_> {
    /// Takes it behind the closed shutter, once a session; a person without an instrument there is asked for the cap.
    pub(super) async fn dark(&mut self, block: &Block) -> Result<(), ScanError> {
        let meter = self.devices.meter.as_ref();
        if self.dark_taken || !meter.properties().needs_dark {
            return Ok(());
        }
        self.shutter(block, false).await?;
        let said = dark::take(meter).await?;
        self.verify().await?;
        self.dark_taken = true;
        said.map_or(Ok(()), |said| self.note(&said))
    }
}
