//! Byte links: serial, TCP, in memory, record and replay.
