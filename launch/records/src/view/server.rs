//! What browsers come to: a listener whose connections are few, timed, and never waited for.

use super::access::{AccessControl, Answer, IO_TIMEOUT, Query};
use hyper::Method;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use rustix::net::sockopt::set_tcp_user_timeout;
use shared::exit::{Exit, Failure};
use shared::output::tell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::{Builder, Runtime};
use tokio::task::AbortHandle;

/// A request line and its headers are shorter [bytes].
const MAX_HEADER_BYTES: usize = 16 << 10;
/// Connections at a time; one more takes the place of the oldest that has not shown the token.
const MAX_CONNECTIONS: usize = 64;
/// Answers that are made at a time; others wait for their turn.
const MAX_CONCURRENT_ANSWERS: usize = 8;
/// Until the next try, after a connection could not be taken.
const ACCEPT_RETRY: Duration = Duration::from_millis(100);

/// A place where nobody has come yet.
pub struct PageServer {
    runtime: Runtime,
    listener: TcpListener,
    access: AccessControl,
    /// Where browsers find it.
    pub address: String,
}

impl PageServer {
    /// Listens on an address of this machine; port 0 is any. Whoever else can reach that address is warned of.
    ///
    /// # Errors
    /// If it is in use, or not this machine's.
    pub fn open(place: SocketAddr) -> Result<PageServer, Failure> {
        let refused = |error: std::io::Error| {
            let advice = "--listen takes an address of this machine, --port a free port, or 0 for any";
            Failure::new(Exit::Usage, format!("{place} cannot be listened on ({error}): {advice}"))
        };
        let runtime = Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(MAX_CONCURRENT_ANSWERS)
            .build()
            .map_err(refused)?;
        let listener = std::net::TcpListener::bind(place).map_err(refused)?;
        // Connections have it from their listener.
        set_tcp_user_timeout(&listener, IO_TIMEOUT.as_millis() as u32).map_err(|error| refused(error.into()))?;
        listener.set_nonblocking(true).map_err(refused)?;
        let place = listener.local_addr().map_err(refused)?;
        let listener = {
            let _within = runtime.enter();
            TcpListener::from_std(listener).map_err(refused)?
        };
        let access = AccessControl::new(place.ip()).map_err(refused)?;
        let shown = SocketAddr::new(reachable_address(place.ip()), place.port());
        if !place.ip().is_loopback() {
            tell(format_args!(
                "warning: the page listens on {place}, unencrypted: whoever has its address with the token, or reads along, \
                 sees and commands what it shows"
            ));
        }
        let address = format!("http://{shown}/?token={}", access.token);
        Ok(PageServer { runtime, listener, access, address })
    }

    /// Answers for ever. A browser that has gone, or breaks off, is no error.
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

/// The address by which this machine's own browser reaches a listener.
fn reachable_address(listening: IpAddr) -> IpAddr {
    match listening {
        IpAddr::V4(address) if address.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(address) if address.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        other => other,
    }
}

/// Serves one connection to its end.
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
                let made = tokio::task::spawn_blocking(move || {
                    let query = Query(head.uri.query().unwrap_or(""));
                    answer(&head.method, head.uri.path(), query, &body)
                });
                made.await.unwrap_or_else(|_| super::access::text(500, "This cannot be answered.\n"))
            }
        }))
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(IO_TIMEOUT).max_buf_size(MAX_HEADER_BYTES);
    let _ = http.serve_connection(TokioIo::new(stream), service).await;
}

/// A connection that is served.
struct Connection {
    task: AbortHandle,
    is_authorized: Arc<AtomicBool>,
}

/// All of them, the oldest first.
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
