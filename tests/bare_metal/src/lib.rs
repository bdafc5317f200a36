//! What a microcontroller runs, without std: for the tests and the program beside this file.
