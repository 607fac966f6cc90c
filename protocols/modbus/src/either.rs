//! One type for both frames, so that a driver need not care which it has.

use std::time::Instant;

use isolux_conversation::{Conversation, Event, Start};

use crate::{Mbap, Reply, Request, Rtu};

/// A conversation in either frame.
#[derive(Debug)]
pub enum Modbus {
    /// On a serial line, or a bridge that carries its bytes.
    Rtu(Rtu),
    /// On a Modbus TCP connection.
    Tcp(Mbap),
}

impl Conversation for Modbus {
    type Request = Request;
    type Answer = Reply;

    fn ready_at(&self, now: Instant) -> Instant {
        match self {
            Self::Rtu(line) => line.ready_at(now),
            Self::Tcp(stream) => stream.ready_at(now),
        }
    }

    fn start(&mut self, now: Instant, request: Request) -> Start<Reply> {
        match self {
            Self::Rtu(line) => line.start(now, request),
            Self::Tcp(stream) => stream.start(now, request),
        }
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Reply>> {
        match self {
            Self::Rtu(line) => line.handle_input(now, bytes),
            Self::Tcp(stream) => stream.handle_input(now, bytes),
        }
    }

    fn surplus(&self) -> u64 {
        match self {
            Self::Rtu(line) => line.surplus(),
            Self::Tcp(stream) => stream.surplus(),
        }
    }

    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        match self {
            Self::Rtu(line) => line.abandon(now),
            Self::Tcp(stream) => stream.abandon(now),
        }
    }
}
