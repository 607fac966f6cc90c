//! What the host asks for.

/// One request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// 0x000010: whether answers carry an MD5 sum.
    Checksum(bool),
    /// 0x000100: the serial number.
    Serial,
    /// 0x100000: gives up what is being acquired.
    Abort,
    /// 0x101100: a raw spectrum.
    Spectrum,
    /// 0x1010A0: counts at which the detector saturates.
    Saturation,
    /// 0x110000: integration time.
    Integration,
    /// 0x110010: sets it, µs.
    SetIntegration(u32),
    /// 0x110110: trigger mode, 0 is free running.
    SetTrigger(u8),
    /// 0x180100: how many coefficients of the wavelength there are.
    WavelengthCount,
    /// 0x180101: one of them, lowest power first, nm.
    Wavelength(u8),
    /// 0x181100: how many coefficients of the non-linearity there are.
    NonlinearityCount,
    /// 0x181101: one of them, lowest power first.
    Nonlinearity(u8),
    /// 0x182001: the irradiance factors of all pixels, µJ a count.
    Irradiance,
    /// 0x182003: the area that collects the light, cm².
    IrradianceArea,
    /// 0x183100: how many coefficients of the stray light there are.
    StrayCount,
    /// 0x183101: one of them.
    Stray(u8),
    /// 0x400000: how many temperatures there are.
    TemperatureCount,
    /// 0x400001: one of them, °C.
    Temperature(u8),
}

impl Request {
    /// The number of its message.
    pub const fn kind(self) -> u32 {
        match self {
            Self::Checksum(_) => 0x0000_0010,
            Self::Serial => 0x0000_0100,
            Self::Abort => 0x0010_0000,
            Self::Spectrum => 0x0010_1100,
            Self::Saturation => 0x0010_10A0,
            Self::Integration => 0x0011_0000,
            Self::SetIntegration(_) => 0x0011_0010,
            Self::SetTrigger(_) => 0x0011_0110,
            Self::WavelengthCount => 0x0018_0100,
            Self::Wavelength(_) => 0x0018_0101,
            Self::NonlinearityCount => 0x0018_1100,
            Self::Nonlinearity(_) => 0x0018_1101,
            Self::Irradiance => 0x0018_2001,
            Self::IrradianceArea => 0x0018_2003,
            Self::StrayCount => 0x0018_3100,
            Self::Stray(_) => 0x0018_3101,
            Self::TemperatureCount => 0x0040_0000,
            Self::Temperature(_) => 0x0040_0001,
        }
    }

    /// Its data.
    pub fn data(self) -> Vec<u8> {
        match self {
            Self::Checksum(md5) => vec![u8::from(md5)],
            Self::SetIntegration(us) => us.to_le_bytes().to_vec(),
            Self::SetTrigger(number)
            | Self::Wavelength(number)
            | Self::Nonlinearity(number)
            | Self::Stray(number)
            | Self::Temperature(number) => vec![number],
            _ => Vec::new(),
        }
    }

    /// Whether it is answered with an acknowledgement and without data.
    pub const fn is_command(self) -> bool {
        matches!(
            self,
            Self::Checksum(_) | Self::Abort | Self::SetIntegration(_) | Self::SetTrigger(_)
        )
    }
}
