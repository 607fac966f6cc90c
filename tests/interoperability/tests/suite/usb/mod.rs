//! USB instruments through the real libusb, against twins behind USB/IP: no hardware, no root, no USB in the kernel.

mod bridge;
pub mod instruments;
pub mod libusb;
pub mod scan;
pub mod seabreeze;
