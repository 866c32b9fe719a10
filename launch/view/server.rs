//! What browsers on this machine come to: one address, a token in it, and a thread for each answer.

use crate::exit::{Exit, Failure};
use messages::clock;
use rustix::net::sockopt::set_tcp_user_timeout;
use std::io::Cursor;
use std::net::TcpListener;
use tiny_http::{Header, Request, Response, Server};

/// Whoever takes nothing of an answer for so long is hung up on [ms].
const PATIENCE_MS: u32 = 5000;

/// An answer that is complete when it begins.
pub type Answer = Response<Cursor<Vec<u8>>>;

/// A place where nobody has come yet.
pub struct Door {
    server: Server,
    token: String,
    /// Where browsers find it.
    pub address: String,
}

impl Door {
    /// Takes a port of this machine's own address; 0 is any.
    ///
    /// # Errors
    /// If it is in use.
    pub fn open(port: u16) -> Result<Door, Failure> {
        let refused = |error: &dyn std::fmt::Display| {
            let advice = format!("port {port} cannot be taken ({error}): choose another by --port, or 0 for any");
            Failure::new(Exit::Usage, advice)
        };
        let listener = TcpListener::bind(("127.0.0.1", port)).map_err(|error| refused(&error))?;
        // Connections have it from their listener.
        set_tcp_user_timeout(&listener, PATIENCE_MS).map_err(|error| refused(&error))?;
        let address = listener.local_addr().map_err(|error| refused(&error))?;
        let server = Server::from_listener(listener, None).map_err(|error| refused(&error))?;
        let token = format!("{:016x}", clock::random());
        Ok(Door { server, address: format!("http://{address}/?token={token}"), token })
    }

    /// Answers for ever; whoever is slow has only itself to wait for. A browser that has gone is no error.
    pub fn serve(self, answer: impl Fn(&mut Request, &str, Query) -> Answer + Send + Sync) {
        std::thread::scope(|scope| {
            for mut request in self.server.incoming_requests() {
                let (answer, token) = (&answer, self.token.as_str());
                scope.spawn(move || {
                    let url = request.url().to_string();
                    let (path, query) = url.split_once('?').unwrap_or((&url, ""));
                    let response = match (path, Query(query)) {
                        ("/favicon.ico", _) => text(204, ""),
                        (_, query) if query.value("token") != Some(token) => text(403, STALE),
                        (path, query) => answer(&mut request, path, query),
                    };
                    let _ = request.respond(with(response, "Cache-Control", "no-store"));
                });
            }
        });
    }
}

const STALE: &str = "This address is not, or no longer, good: open the one that `biped view` printed last.\n";

/// What follows the question mark of an address.
#[derive(Clone, Copy)]
pub struct Query<'a>(&'a str);

impl<'a> Query<'a> {
    /// The value of a key.
    pub fn value(self, key: &str) -> Option<&'a str> {
        self.0.split('&').find_map(|part| part.strip_prefix(key)?.strip_prefix('='))
    }
}

/// The page itself.
pub fn html(page: &str) -> Answer {
    with(text(200, page), "Content-Type", "text/html; charset=utf-8")
}

/// What no address leads to.
pub fn nothing() -> Answer {
    text(404, "There is nothing here.\n")
}

/// Words for people.
pub fn text(status: u16, words: &str) -> Answer {
    Response::from_string(words).with_status_code(status)
}

/// With one header more, of plain ASCII.
pub fn with(response: Answer, name: &str, value: &str) -> Answer {
    match Header::from_bytes(name, value) {
        Ok(header) => response.with_header(header),
        Err(()) => response,
    }
}
