//! Attacks on a running bench. The twins serve in a process of their own over TCP and in real time, the program runs
//! against them, and each file here disturbs it in one way. Whatever happens: no wrong row, no row twice, and the axes
//! rest. Beside them run the days that nobody disturbs: the attacks wait for their instruments most of the time.
//!
//!     cargo test -p isolux --test attacks                                            # short, as in CI
//!     ISOLUX_ATTACK_ROUNDS=50 ISOLUX_ATTACK_SEED=7 cargo test -p isolux --test attacks -- --nocapture
//!
//! `ISOLUX_TEST_DIR` keeps the folders.

mod days;
#[path = "../suite/folder.rs"]
mod folder;

#[cfg(unix)]
mod damaged_records;
#[cfg(unix)]
mod interference;
#[cfg(unix)]
mod killed_days;
#[cfg(unix)]
mod kills;
#[cfg(unix)]
mod second_process;
#[cfg(unix)]
mod sleeps;
#[cfg(unix)]
mod support;
#[cfg(unix)]
mod sweeps;
#[cfg(unix)]
mod undisturbed;

use libtest_mimic::{Arguments, Trial};

/// One trial a function, under its path.
macro_rules! trials {
    ($($module:ident::$test:ident),* $(,)?) => {
        vec![$(Trial::test(concat!(stringify!($module), "::", stringify!($test)), || {
            $module::$test();
            Ok(())
        })),*]
    };
}

fn main() -> std::process::ExitCode {
    let mut tests = trials![
        days::a_day_in_motion_agrees_with_its_model_and_with_the_lamp,
        days::a_day_is_taken_up_and_reported_as_it_was_asked_and_reduced,
        days::a_gap_on_the_axis_is_told_with_what_could_make_it,
        days::one_seed_gives_one_day,
        days::the_day_ends_with_files_that_agree_with_what_was_read,
    ];
    #[cfg(unix)]
    tests.extend(attacks());
    // Each waits for the instruments of a bench of its own and computes next to nothing, or computes at low priority:
    // all of them at once.
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(tests.len());
    #[cfg(unix)]
    tests.extend(campaigns());
    libtest_mimic::run(&arguments, tests).exit_code()
}

#[cfg(unix)]
fn attacks() -> Vec<Trial> {
    trials![
        damaged_records::a_damaged_record_is_refused_or_gives_the_same_numbers,
        damaged_records::rows_and_pixels_that_are_lost_are_named_and_can_be_read_again,
        interference::what_a_second_hand_does_is_in_no_row_and_in_no_result,
        killed_days::a_killed_day_gives_what_the_undisturbed_day_gives,
        killed_days::a_killed_day_in_motion_sweeps_what_the_undisturbed_day_sweeps,
        killed_days::axes_whose_program_is_killed_in_a_sweep_come_to_rest_inside_their_limits,
        kills::every_signal_stops_the_axes_and_says_so_in_the_record,
        kills::a_hangup_that_is_ignored_stays_so,
        kills::killed_again_and_again_it_comes_to_its_end,
        second_process::nobody_else_gets_at_a_bench_that_is_scanned,
        second_process::of_two_scans_that_begin_at_once_no_row_is_wrong,
        second_process::stop_ends_a_scan_that_works_and_the_scan_says_so,
        second_process::stop_gets_through_while_its_owner_is_suspended_and_the_owner_drives_no_more,
        second_process::stop_gets_through_after_its_owner_was_killed,
        second_process::a_scan_that_hangs_is_taken_over_with_a_reason_and_writes_nothing_more,
        sleeps::stopped_at_any_moment_it_goes_on_and_blames_nobody,
        sweeps::killed_in_a_sweep_at_most_that_sweep_is_made_again,
        undisturbed::a_scan_that_nobody_disturbs_is_complete_and_right,
    ]
}

/// Minutes and hours, for a person.
#[cfg(unix)]
fn campaigns() -> Vec<Trial> {
    let campaigns = trials![
        killed_days::as_many_killed_days_as_asked_give_what_undisturbed_days_give,
        killed_days::as_many_killed_days_in_motion_as_asked_give_what_undisturbed_days_give,
        killed_days::axes_come_to_rest_inside_their_limits_at_as_many_kills_as_asked,
    ];
    campaigns
        .into_iter()
        .map(|campaign| campaign.with_ignored_flag(true))
        .collect()
}
