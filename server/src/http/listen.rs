//! Accepts connections, each served with the routes until it ends or has been still for too long.

use std::convert::Infallible;
use std::io;
use std::pin::{Pin, pin};
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::Router;
use axum::body::Body;
use axum::extract::Request;
use axum::response::Response;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::TokioIo;
use socket2::SockRef;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{mpsc, watch};
use tower::ServiceExt;

use super::connections::{Connection, Connections, Place, Stage};

/// Time between two looks for connections that have been still for too long.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Time to wait when the system refuses a connection, mostly for want of descriptors.
const AFTER_ERROR: Duration = Duration::from_millis(100);
/// Most bytes of a request's head, and of what is read at once.
const MAX_BUFFER_BYTES: usize = 64 << 10;
/// Most bytes of answers that wait in the kernel until a client takes what is before them.
const MAX_UNSENT_BYTES: u32 = 128 << 10;
/// What a client reads for which there is no place at all.
const NO_PLACE: &[u8] =
    b"HTTP/1.1 503 Service Unavailable\r\nretry-after: 1\r\ncontent-length: 0\r\nconnection: close\r\n\r\n";

/// Serves until the signal comes, then until open requests have ended; beside so many runs that are
/// stepped at once.
pub async fn listen(
    listener: TcpListener,
    routes: Router,
    runs: usize,
    stop: impl Future<Output = ()>,
) {
    let connections = Arc::new(Connections::beside(runs));
    let (stopping, stopped) = watch::channel(());
    // Closed when the last connection has ended.
    let (open, mut all_ended) = mpsc::channel::<Infallible>(1);
    let mut stop = pin!(stop);
    let mut look = tokio::time::interval(LOOK_EVERY);
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = look.tick() => {
                connections.close_overdue();
                continue;
            }
            () = &mut stop => break,
        };
        let (stream, address) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                tracing::warn!(%error, "a connection cannot be accepted");
                tokio::time::sleep(AFTER_ERROR).await;
                continue;
            }
        };
        let Some(place) = connections.admit(address.ip()) else {
            // Whether it arrives or not, the client sees the connection end.
            drop(stream.try_write(NO_PLACE));
            continue;
        };
        let (routes, stopped, open) = (routes.clone(), stopped.clone(), open.clone());
        tokio::spawn(async move {
            serve(stream, place, routes, stopped).await;
            drop(open);
        });
    }
    drop((stopping, open, listener));
    let mut look = tokio::time::interval(LOOK_EVERY);
    loop {
        tokio::select! {
            _ = all_ended.recv() => return,
            _ = look.tick() => connections.close_overdue(),
        }
    }
}

/// Serves one connection.
async fn serve(stream: TcpStream, place: Place, routes: Router, mut stopped: watch::Receiver<()>) {
    // Small answers go out at once; where that cannot be had they are only slower.
    drop(stream.set_nodelay(true));
    // So that what waits in the kernel is no more than what a slow client takes in a moment, and it
    // is seen that it does.
    drop(SockRef::from(&stream).set_tcp_notsent_lowat(MAX_UNSENT_BYTES));
    let connection = &place.connection;
    let service = service_fn(|request: Request<Incoming>| {
        let (routes, connection) = (routes.clone(), Arc::clone(connection));
        async move {
            let mut request = request.map(Body::new);
            connection.enter(Stage::Working);
            request.extensions_mut().insert(Arc::clone(&connection));
            let response: Result<Response, Infallible> = routes.oneshot(request).await;
            connection.enter(Stage::Idle);
            response
        }
    });
    let io = TokioIo::new(Watched {
        stream,
        connection: Arc::clone(connection),
    });
    let served = http1::Builder::new()
        // The times of a connection are kept here, not there.
        .header_read_timeout(None)
        .max_buf_size(MAX_BUFFER_BYTES)
        .serve_connection(io, service);
    let mut served = pin!(served);
    let ended = tokio::select! {
        ended = &mut served => ended,
        () = connection.closed() => return,
        // The sender is dropped when the server stops.
        _ = stopped.changed() => {
            served.as_mut().graceful_shutdown();
            tokio::select! {
                ended = &mut served => ended,
                () = connection.closed() => return,
            }
        }
    };
    if let Err(error) = ended {
        tracing::debug!(%error, "a connection broke off");
    }
}

/// A stream that tells of every byte.
struct Watched {
    stream: TcpStream,
    connection: Arc<Connection>,
}

impl AsyncRead for Watched {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        if buffer.filled().len() > before {
            self.connection.has_read();
        }
        read
    }
}

impl AsyncWrite for Watched {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        if let Poll::Ready(Ok(1..)) = written {
            self.connection.has_written();
        }
        written
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, parts);
        if let Poll::Ready(Ok(1..)) = written {
            self.connection.has_written();
        }
        written
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
