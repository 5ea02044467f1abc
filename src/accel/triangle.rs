//! The triangle test of Havel and Herout.
