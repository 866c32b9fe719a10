//! HTTP server of the page. The number and the duration of connections are limited, and no connection blocks another.

use super::access::{AccessControl, Answer, IO_TIMEOUT, Query};
use hyper::Method;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use rustix::net::sockopt::set_tcp_user_timeout;
use shared::exit::{Exit, Failure};
use shared::output::log;
use shared::thread;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::task::AbortHandle;

/// Greatest length of a request line with headers [bytes].
const MAX_HEADER_BYTES: usize = 16 << 10;
/// Greatest number of connections. A further one replaces the oldest connection without authorisation.
const MAX_CONNECTIONS: usize = 64;
/// Greatest number of answers that are computed at the same time.
const MAX_CONCURRENT_ANSWERS: usize = 8;
/// Time that an idle thread is kept: longer than a run, so that there is always one. Otherwise tokio panics if the system refuses a new one.
const THREAD_KEEP_ALIVE: Duration = Duration::from_secs(365 * 24 * 3600);
/// Delay after a failure to accept a connection.
const ACCEPT_RETRY: Duration = Duration::from_millis(100);

/// A server that listens and does not answer yet.
pub struct PageServer {
    runtime: Runtime,
    listener: TcpListener,
    access: AccessControl,
    /// URL with the token.
    pub url: String,
}

impl PageServer {
    /// Listens on an address of this machine. Port 0 selects a free port. Prints a warning if other machines can connect.
    ///
    /// # Errors
    /// If the address is in use or does not belong to this machine.
    pub fn open(address: SocketAddr) -> Result<PageServer, Failure> {
        let refuse = |error: std::io::Error| {
            let advice = "--listen needs an address of this machine, and --port a free port or 0";
            Failure::new(Exit::Usage, format!("cannot listen on {address} ({error}): {advice}"))
        };
        let runtime = Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(MAX_CONCURRENT_ANSWERS)
            .thread_keep_alive(THREAD_KEEP_ALIVE)
            .build()
            .map_err(refuse)?;
        thread::start(|| ())?;
        let _ = runtime.block_on(runtime.spawn_blocking(|| ()));
        let listener = std::net::TcpListener::bind(address).map_err(refuse)?;
        // Connections inherit this option from the listener.
        set_tcp_user_timeout(&listener, IO_TIMEOUT.as_millis() as u32).map_err(|error| refuse(error.into()))?;
        listener.set_nonblocking(true).map_err(refuse)?;
        let address = listener.local_addr().map_err(refuse)?;
        let listener = {
            let _within = runtime.enter();
            TcpListener::from_std(listener).map_err(refuse)?
        };
        let access = AccessControl::new(address.ip()).map_err(refuse)?;
        let url_address = SocketAddr::new(reachable_address(address.ip()), address.port());
        if !address.ip().is_loopback() {
            log(format_args!(
                "warning: the page listens on {address} without encryption: anybody who knows its URL with the token, or \
                 intercepts the traffic, can watch and control the session"
            ));
        }
        let url = format!("http://{url_address}/?token={}", access.token);
        Ok(PageServer { runtime, listener, access, url })
    }

    /// Answers requests forever. A browser that disconnects is no error.
    pub fn serve(self, answer: impl Fn(&Method, &str, Query, &str) -> Answer + Send + Sync + 'static) {
        let PageServer { runtime, listener, access, .. } = self;
        let (access, answer) = (Arc::new(access), Arc::new(answer));
        runtime.block_on(async {
            let mut connections = Connections::default();
            loop {
                let Ok((stream, _)) = listener.accept().await else {
                    tokio::time::sleep(ACCEPT_RETRY).await;
                    continue;
                };
                let is_authorized = Arc::new(AtomicBool::new(false));
                let task =
                    tokio::spawn(serve_connection(stream, is_authorized.clone(), access.clone(), answer.clone()));
                connections.add(Connection { task: task.abort_handle(), is_authorized });
            }
        });
    }
}

/// The address under which a browser on this machine reaches the server.
fn reachable_address(listening: IpAddr) -> IpAddr {
    match listening {
        IpAddr::V4(address) if address.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(address) if address.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        other => other,
    }
}

/// Serves one connection until it closes.
async fn serve_connection<A>(
    stream: TcpStream,
    is_authorized: Arc<AtomicBool>,
    access: Arc<AccessControl>,
    answer: Arc<A>,
) where
    A: Fn(&Method, &str, Query, &str) -> Answer + Send + Sync + 'static,
{
    let service = service_fn(async |request| {
        Ok::<Answer, Infallible>(access.add_headers(match access.authorize(request, &is_authorized).await {
            Err(refusal) => refusal,
            Ok((head, body)) => {
                let answer = answer.clone();
                let answer = tokio::task::spawn_blocking(move || {
                    let query = Query(head.uri.query().unwrap_or(""));
                    answer(&head.method, head.uri.path(), query, &body)
                });
                answer.await.unwrap_or_else(|_| super::access::text(500, "Internal error.\n"))
            }
        }))
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(IO_TIMEOUT).max_buf_size(MAX_HEADER_BYTES);
    let _ = http.serve_connection(TokioIo::new(stream), service).await;
}

/// An open connection.
struct Connection {
    task: AbortHandle,
    is_authorized: Arc<AtomicBool>,
}

/// Open connections, oldest first.
#[derive(Default)]
struct Connections(VecDeque<Connection>);

impl Connections {
    fn add(&mut self, connection: Connection) {
        self.0.retain(|connection| !connection.task.is_finished());
        if self.0.len() == MAX_CONNECTIONS {
            let victim = self.0.iter().position(|connection| !connection.is_authorized.load(Relaxed)).unwrap_or(0);
            self.0.remove(victim).inspect(|connection| connection.task.abort());
        }
        self.0.push_back(connection);
    }
}
