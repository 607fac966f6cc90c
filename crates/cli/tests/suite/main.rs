//! The program as a person has it: by its commands, files, exit codes and page. One test program, so that the tests
//! that wait for instruments run beside those that compute.

mod acceptance;
mod bench;
mod book;
mod broken_off;
mod browser;
mod darkroom_loop;
mod electrical;
mod flicker;
mod folder;
mod impossible_jobs;
mod inspect;
mod investigate;
mod output;
mod plan_for_sensor;
mod rated_day;
mod simulate;
mod twin_faults;
mod verify;
