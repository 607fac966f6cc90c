//! Drivers of lux meters on scripted instruments.

mod ascii;
mod modbus;
mod t10a;
mod text_lines;
