//! Drivers of spectroradiometers on scripted instruments.

mod obp;
mod ooi;
