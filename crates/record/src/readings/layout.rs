//! The columns of a readings file, by its format.

/// The header row. The first thirteen columns are the common ones of every readings file.
pub const HEADER: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,voltage_v,current_a,power_w,power_factor,\
session,burning,lamp_s,chain,row_crc";

/// Which columns a file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layout {
    /// Format 3: no time on the axis of the run, `time_s` counts from the last switching on of the lamp.
    V3,
    /// Format 4.
    #[default]
    V4,
}

impl Layout {
    /// All of them.
    pub(crate) const ALL: [Self; 2] = [Self::V3, Self::V4];

    /// Whether each row has its time on the axis of the run, beside that of the lamp.
    pub const fn has_run_time(self) -> bool {
        matches!(self, Self::V4)
    }

    /// The header row with its line end.
    pub fn header(self) -> String {
        match self {
            Self::V3 => format!("{}\n", HEADER.replace("lamp_s,", "")),
            Self::V4 => format!("{HEADER}\n"),
        }
    }

    pub(super) const fn columns(self) -> usize {
        match self {
            Self::V3 => 29,
            Self::V4 => 30,
        }
    }
}
