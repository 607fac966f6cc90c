//! The columns of a readings file, by its format.

/// The header row. The first thirteen columns are the common ones of every readings file.
pub const HEADER: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,voltage_v,current_a,power_w,power_factor,\
session,burning,lamp_s,chain,row_crc";

/// The header row of format 3, in which `time_s` counts from the last switching on of the lamp, as in those before.
pub(super) const HEADER_3: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,voltage_v,current_a,power_w,power_factor,\
session,burning,chain,row_crc";

/// The header row of format 2.
pub(super) const HEADER_2: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,session,burning,chain,row_crc";

/// The header row of format 1.
pub(super) const HEADER_1: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx,\
quality,role,point,repeat,c_target_deg,gamma_target_deg,digit_lx,integration_s,raw,row_crc";

/// Which columns a file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layout {
    /// Format 1: no `session`, `burning`, `chain`.
    V1,
    /// Format 2: no electrical columns.
    V2,
    /// Format 3: no time on the axis of the run, `time_s` is that of the lamp.
    V3,
    /// Format 4.
    #[default]
    V4,
}

impl Layout {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::V1, Self::V2, Self::V3, Self::V4];

    /// Whether each row has the hash of all rows up to it, and run.toml its own.
    pub const fn has_hashes(self) -> bool {
        !matches!(self, Self::V1)
    }

    /// Whether each row has its time on the axis of the run, beside that of the lamp.
    pub const fn has_run_time(self) -> bool {
        matches!(self, Self::V4)
    }

    /// Whether each row has the readings of a power meter.
    pub(super) const fn has_electrical(self) -> bool {
        matches!(self, Self::V3 | Self::V4)
    }

    /// The header row with its line end.
    pub fn header(self) -> String {
        match self {
            Self::V1 => format!("{HEADER_1}\n"),
            Self::V2 => format!("{HEADER_2}\n"),
            Self::V3 => format!("{HEADER_3}\n"),
            Self::V4 => format!("{HEADER}\n"),
        }
    }

    pub(super) const fn columns(self) -> usize {
        match self {
            Self::V1 => 22,
            Self::V2 => 25,
            Self::V3 => 29,
            Self::V4 => 30,
        }
    }
}
