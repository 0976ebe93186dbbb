//! The promises, at the process boundary: the real program, run as a person runs it.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    clippy::print_stdout,
    clippy::unwrap_used,
    unreachable_pub,
    reason = "a test that cannot go on stops, and says what it saw"
)]

mod acceptance;
mod agreement;
mod agreement_at_large;
mod architecture;
mod bad_input;
mod batch;
mod batch_failures;
mod batch_long;
mod browser;
mod buckets;
mod cabinet;
mod canary;
mod canary_forms;
mod cases;
mod check;
mod check_in_ci;
mod circles;
mod clients;
mod corpus;
mod corrections;
mod critic;
mod desk;
mod engines;
mod eval;
mod examples;
mod exports;
mod fitness;
mod fixes;
mod folders;
mod forged;
mod friendly;
mod given_axes;
mod inert;
mod kills;
mod kills_paid;
mod kinfold;
mod layouts;
mod looking;
mod make;
mod mesh_formats;
mod money;
mod mutants;
mod notice;
mod pages;
mod paid;
mod programs;
mod providers;
mod real_servers;
mod replays;
mod report_page;
mod restate;
mod resume;
mod serve;
mod server;
mod services;
mod signatures;
mod slow_checks;
mod strangers;
mod studio;
mod studio_question;
mod sureness;
mod survival;
mod train;
mod transcripts;
mod trust;
mod turns;
mod wrong_inputs;
