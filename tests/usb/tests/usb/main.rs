//! USB instruments through the real libusb, against twins behind USB/IP: no hardware, no root, no USB in the kernel.

mod bridge;
mod instruments;
mod libusb;
mod scan;
mod seabreeze;
