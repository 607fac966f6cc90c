//! How the catalogue opens the axes of a driver.

/// The factory of a driver whose method `axis` opens axes in degrees and in millimetres.
macro_rules! axis_factory {
    ($driver:ty) => {
        #[async_trait::async_trait]
        impl isolux_device::AxisFactory for $driver {
            async fn open_axis(
                &self,
                target: &isolux_device::Target,
                settings: isolux_device::AxisSettings,
            ) -> Result<Box<dyn isolux_device::Axis>, isolux_device::OpenError> {
                Ok(Box::new(self.axis(target, settings).await?))
            }

            async fn open_linear_axis(
                &self,
                target: &isolux_device::Target,
                settings: isolux_device::AxisSettings<isolux_units::Millimetre>,
            ) -> Result<Box<dyn isolux_device::Axis<isolux_units::Millimetre>>, isolux_device::OpenError> {
                Ok(Box::new(self.axis(target, settings).await?))
            }
        }
    };
}
pub(crate) use axis_factory;
