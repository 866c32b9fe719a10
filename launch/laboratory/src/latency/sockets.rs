//! The same messages over sockets, for which the kernel copies data and wakes processes.

use super::terms::{LOST, PATIENCE};
use shared::exit::{Exit, Failure};
use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, UdpSocket};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener, UnixStream};
use std::time::Instant;

/// Size of a message [bytes]: between sensors and command.
pub const SIZE: usize = 200;

/// The fill byte of the last message.
const END: u8 = u8::MAX;

/// One end of a connection.
pub enum Socket {
    /// A Unix stream.
    Unix(UnixStream),
    /// UDP over loopback.
    Udp(UdpSocket),
}

/// A listening socket.
pub enum Meeting {
    /// A Unix socket with an abstract name.
    Unix(UnixListener),
    /// A UDP port.
    Udp(UdpSocket),
}

fn broken(error: std::io::Error) -> Failure {
    Failure::new(Exit::Fault, format!("sockets for the comparison: {error}"))
}

impl Meeting {
    /// A Unix socket called `name`.
    ///
    /// # Errors
    /// A system that refuses it.
    pub fn unix(name: &str) -> Result<Meeting, Failure> {
        let address = SocketAddr::from_abstract_name(name).map_err(broken)?;
        UnixListener::bind_addr(&address).map(Meeting::Unix).map_err(broken)
    }

    /// A UDP port; returns its number.
    ///
    /// # Errors
    /// A system that refuses it.
    pub fn udp() -> Result<(Meeting, u16), Failure> {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(broken)?;
        let port = socket.local_addr().map_err(broken)?.port();
        Ok((Meeting::Udp(socket), port))
    }

    /// Waits for the peer, which sends a message first.
    ///
    /// # Errors
    /// A peer that does not connect.
    pub fn accept(self, spins: bool) -> Result<Socket, Failure> {
        match self {
            Meeting::Unix(listener) => Socket::Unix(listener.accept().map_err(broken)?.0).set(spins),
            Meeting::Udp(socket) => {
                socket.set_read_timeout(Some(PATIENCE)).map_err(broken)?;
                let (_, peer) = socket.recv_from(&mut [0; SIZE]).map_err(broken)?;
                socket.connect(peer).map_err(broken)?;
                Socket::Udp(socket).set(spins)
            }
        }
    }
}

impl Socket {
    /// Connects to the Unix socket.
    ///
    /// # Errors
    /// A socket that does not exist.
    pub fn unix(name: &str, spins: bool) -> Result<Socket, Failure> {
        let address = SocketAddr::from_abstract_name(name).map_err(broken)?;
        Socket::Unix(UnixStream::connect_addr(&address).map_err(broken)?).set(spins)
    }

    /// Connects to the UDP port.
    ///
    /// # Errors
    /// A system that refuses it.
    pub fn udp(port: u16, spins: bool) -> Result<Socket, Failure> {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(broken)?;
        socket.connect((Ipv4Addr::LOCALHOST, port)).map_err(broken)?;
        socket.send(&[0; SIZE]).map_err(broken)?;
        Socket::Udp(socket).set(spins)
    }

    fn set(self, spins: bool) -> Result<Socket, Failure> {
        let limit = Some(PATIENCE);
        match &self {
            Socket::Unix(socket) => socket.set_nonblocking(spins).and_then(|()| socket.set_read_timeout(limit)),
            Socket::Udp(socket) => socket.set_nonblocking(spins).and_then(|()| socket.set_read_timeout(limit)),
        }
        .map_err(broken)?;
        Ok(self)
    }

    /// Sends a message and waits for the answer.
    ///
    /// # Errors
    /// No answer in time.
    pub fn ask(&mut self, message: &mut [u8; SIZE]) -> Result<(), Failure> {
        self.send(message)?;
        self.receive(message)
    }

    /// Announces the end.
    ///
    /// # Errors
    /// If the connection breaks.
    pub fn end(&mut self) -> Result<(), Failure> {
        self.send(&[END; SIZE])
    }

    /// Sends every message back until the end.
    ///
    /// # Errors
    /// No message in time.
    pub fn serve(&mut self) -> Result<(), Failure> {
        let mut message = [0; SIZE];
        loop {
            self.receive(&mut message)?;
            if message[0] == END {
                return Ok(());
            }
            self.send(&message)?;
        }
    }

    fn send(&mut self, message: &[u8; SIZE]) -> Result<(), Failure> {
        match self {
            Socket::Unix(socket) => socket.write_all(message),
            Socket::Udp(socket) => socket.send(message).map(drop),
        }
        .map_err(broken)
    }

    fn receive(&mut self, message: &mut [u8; SIZE]) -> Result<(), Failure> {
        let start = Instant::now();
        let mut have = 0;
        while have < SIZE {
            let got = match self {
                Socket::Unix(socket) => socket.read(&mut message[have..]),
                Socket::Udp(socket) => socket.recv(message),
            };
            match got {
                Ok(0) => return Err(Failure::new(Exit::PeerMissing, LOST)),
                Ok(count) => have += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => (),
                Err(error) if error.kind() == ErrorKind::WouldBlock && start.elapsed() < PATIENCE => (),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    return Err(Failure::new(Exit::PeerMissing, LOST));
                }
                Err(error) => return Err(broken(error)),
            }
        }
        Ok(())
    }
}
