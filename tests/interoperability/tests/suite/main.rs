//! Our links and twins against software of others: libusb and the libraries of makers. Where one is missing its tests
//! say that they were skipped, and fail where `ISOLUX_NO_SKIP` is set.

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

mod modbus_clients;
mod modbus_servers;
mod peers;
mod pyvisa;
mod usb;
mod zaber_motion;

/// One trial a function, under its path.
macro_rules! trials {
    ($($($part:ident)::+),* $(,)?) => {
        vec![$(Trial::test(stringify!($($part)::+).replace(' ', ""), || {
            let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
            runtime.block_on($($part)::+());
            Ok(())
        })),*]
    };
}

fn main() -> ExitCode {
    let trials = trials![
        modbus_clients::pymodbus_reads_our_meter_in_both_frames,
        modbus_clients::mbpoll_reads_our_meter_in_both_frames,
        modbus_clients::pymodbus_homes_and_moves_our_drives,
        modbus_servers::pymodbus_serves_us_over_tcp,
        modbus_servers::pymodbus_serves_us_on_a_pty,
        pyvisa::pyvisa_reads_our_power_meter_over_tcp_and_on_a_line,
        pyvisa::pyvisa_switches_our_supply_over_tcp_and_on_a_line,
        pyvisa::a_twin_that_answers_wrongly_is_found_out,
        usb::instruments::ocean_ooi_reads_calibration_and_spectrum_over_usb,
        usb::instruments::ocean_obp_reads_calibration_and_spectrum_over_usb,
        usb::instruments::an_instrument_that_is_unplugged_says_so,
        usb::libusb::transfers_become_frames_and_a_spectrum_ends_with_its_short_packet,
        usb::libusb::silence_is_a_timeout_and_nothing_is_lost_by_it,
        usb::libusb::a_stall_is_cleared_and_an_overflow_costs_its_answer_alone,
        usb::libusb::unplugged_is_said_and_the_device_is_not_found_again,
        usb::libusb::an_address_chooses_by_serial_number_and_a_link_is_opened_again,
        usb::libusb::an_instrument_that_another_link_has_is_in_use,
        usb::scan::a_scan_with_the_spectrometer_on_usb_reads_what_it_reads_over_tcp,
        usb::seabreeze::the_makers_library_reads_a_usb2000_and_sees_each_field_changed,
        usb::seabreeze::the_makers_library_reads_an_sts_and_sees_each_field_changed,
        zaber_motion::the_makers_library_reads_what_is_true,
        zaber_motion::the_makers_library_reports_a_stall_and_an_alarm,
        zaber_motion::what_is_changed_on_the_way_is_read_otherwise,
    ];
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(trials.len());
    libtest_mimic::run(&arguments, trials).exit_code()
}
