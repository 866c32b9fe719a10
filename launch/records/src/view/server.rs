//! What browsers come to: a listener whose connections are few, timed, and never waited for.

use super::admission::{Admission, Answer, PATIENCE, Query};
use hyper::Method;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use rustix::net::sockopt::set_tcp_user_timeout;
use shared::exit::{Exit, Failure};
use shared::output::log;
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
const LONGEST_HEAD: usize = 16 << 10;
/// Connections at a time; one more takes the place of the oldest that has not shown the token.
const MOST: usize = 64;
/// Answers that are made at a time; others wait for their turn.
const AT_ONCE: usize = 8;
/// Until the next try, after a connection could not be taken.
const AGAIN: Duration = Duration::from_millis(100);

/// A place where nobody has come yet.
pub struct Door {
    runtime: Runtime,
    listener: TcpListener,
    admission: Admission,
    /// Where browsers find it.
    pub address: String,
}

impl Door {
    /// Listens on an address of this machine; port 0 is any. Whoever else can reach that address is warned of.
    ///
    /// # Errors
    /// If it is in use, or not this machine's.
    pub fn open(place: SocketAddr) -> Result<Door, Failure> {
        let refused = |error: std::io::Error| {
            let advice = "--listen takes an address of this machine, --port a free port, or 0 for any";
            Failure::new(Exit::Usage, format!("{place} cannot be listened on ({error}): {advice}"))
        };
        let runtime =
            Builder::new_current_thread().enable_all().max_blocking_threads(AT_ONCE).build().map_err(refused)?;
        let listener = std::net::TcpListener::bind(place).map_err(refused)?;
        // Connections have it from their listener.
        set_tcp_user_timeout(&listener, PATIENCE.as_millis() as u32).map_err(|error| refused(error.into()))?;
        listener.set_nonblocking(true).map_err(refused)?;
        let place = listener.local_addr().map_err(refused)?;
        let listener = {
            let _within = runtime.enter();
            TcpListener::from_std(listener).map_err(refused)?
        };
        let admission = Admission::new(place.ip()).map_err(refused)?;
        let shown = SocketAddr::new(here(place.ip()), place.port());
        if !place.ip().is_loopback() {
            log(format_args!(
                "warning: the page listens on {place}, unencrypted: whoever has its address with the token, or reads along, \
                 sees and commands what it shows"
            ));
        }
        let address = format!("http://{shown}/?token={}", admission.token);
        Ok(Door { runtime, listener, admission, address })
    }

    /// Answers for ever. A browser that has gone, or breaks off, is no error.
    pub fn serve(self, answer: impl Fn(&Method, &str, Query, &str) -> Answer + Send + Sync + 'static) {
        let Door { runtime, listener, admission, .. } = self;
        let (admission, answer) = (Arc::new(admission), Arc::new(answer));
        runtime.block_on(async {
            let mut guests = Guests::default();
            loop {
                let Ok((stream, _)) = listener.accept().await else {
                    tokio::time::sleep(AGAIN).await;
                    continue;
                };
                let is_known = Arc::new(AtomicBool::new(false));
                let task = tokio::spawn(attend(stream, is_known.clone(), admission.clone(), answer.clone()));
                guests.admit(Guest { task: task.abort_handle(), is_known });
            }
        });
    }
}

/// The address by which this machine's own browser reaches a listener.
fn here(listening: IpAddr) -> IpAddr {
    match listening {
        IpAddr::V4(address) if address.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(address) if address.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        other => other,
    }
}

/// Serves one connection to its end.
async fn attend<A>(stream: TcpStream, is_known: Arc<AtomicBool>, admission: Arc<Admission>, answer: Arc<A>)
where
    A: Fn(&Method, &str, Query, &str) -> Answer + Send + Sync + 'static,
{
    let service = service_fn(async |request| {
        Ok::<Answer, Infallible>(admission.dress(match admission.admit(request, &is_known).await {
            Err(refusal) => refusal,
            Ok((head, body)) => {
                let answer = answer.clone();
                let made = tokio::task::spawn_blocking(move || {
                    let query = Query(head.uri.query().unwrap_or(""));
                    answer(&head.method, head.uri.path(), query, &body)
                });
                made.await.unwrap_or_else(|_| super::admission::text(500, "This cannot be answered.\n"))
            }
        }))
    });
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(PATIENCE).max_buf_size(LONGEST_HEAD);
    let _ = http.serve_connection(TokioIo::new(stream), service).await;
}

/// A connection that is served.
struct Guest {
    task: AbortHandle,
    is_known: Arc<AtomicBool>,
}

/// All of them, the oldest first.
#[derive(Default)]
struct Guests(VecDeque<Guest>);

impl Guests {
    fn admit(&mut self, guest: Guest) {
        self.0.retain(|guest| !guest.task.is_finished());
        if self.0.len() == MOST {
            let stranger = self.0.iter().position(|guest| !guest.is_known.load(Relaxed)).unwrap_or(0);
            self.0.remove(stranger).inspect(|guest| guest.task.abort());
        }
        self.0.push_back(guest);
    }
}
