//! Routes that say what they do: the one way by which the service gets a route.

use axum::Router;
use axum::extract::Request;
use axum::handler::Handler;
use axum::http::Method;
use axum::middleware::{Next, from_fn};
use axum::routing::{MethodRouter, delete, get, post, put};

use super::App;
use super::operation::Operation;
use super::query;

/// A method of a route, and what it does.
#[derive(Clone, Debug)]
pub struct Described {
    /// The method.
    pub method: Method,
    /// The path, with `{id}` and the like.
    pub path: String,
    /// What it does.
    pub operation: Operation,
}

/// Routes with what each does.
#[derive(Default)]
pub struct Routes {
    router: Router<App>,
    described: Vec<Described>,
}

impl Routes {
    /// None yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// With a route to read something (`GET`, and `HEAD`).
    #[must_use]
    pub fn get<H: Handler<T, App>, T: 'static>(
        self,
        path: &str,
        handler: H,
        operation: Operation,
    ) -> Self {
        self.add(Method::GET, path, get(handler), operation)
    }

    /// With a route to make or change something.
    #[must_use]
    pub fn post<H: Handler<T, App>, T: 'static>(
        self,
        path: &str,
        handler: H,
        operation: Operation,
    ) -> Self {
        self.add(Method::POST, path, post(handler), operation)
    }

    /// With a route to bring something.
    #[must_use]
    pub fn put<H: Handler<T, App>, T: 'static>(
        self,
        path: &str,
        handler: H,
        operation: Operation,
    ) -> Self {
        self.add(Method::PUT, path, put(handler), operation)
    }

    /// With a route to delete something.
    #[must_use]
    pub fn delete<H: Handler<T, App>, T: 'static>(
        self,
        path: &str,
        handler: H,
        operation: Operation,
    ) -> Self {
        self.add(Method::DELETE, path, delete(handler), operation)
    }

    /// With a form of a route to read something that the handler of another path serves too.
    #[must_use]
    pub fn also_read_as(mut self, path: &str, operation: Operation) -> Self {
        self.describe(Method::GET, path, operation);
        self
    }

    /// With the routes of others.
    #[must_use]
    pub fn merge(mut self, others: Self) -> Self {
        self.router = self.router.merge(others.router);
        self.described.extend(others.described);
        self
    }

    /// With the routes of others below a path.
    #[must_use]
    pub fn below(mut self, prefix: &str, others: Self) -> Self {
        self.router = self.router.nest(prefix, others.router);
        for described in others.described {
            let path = format!("{prefix}{}", described.path);
            self.describe(described.method, &path, described.operation);
        }
        self
    }

    /// What they do, and the router that does it.
    pub fn into_parts(self) -> (Vec<Described>, Router<App>) {
        (self.described, self.router)
    }

    fn add(
        mut self,
        method: Method,
        path: &str,
        route: MethodRouter<App>,
        operation: Operation,
    ) -> Self {
        let known = operation.query;
        let check = move |request: Request, next: Next| query::check(known, request, next);
        self.router = self.router.route(path, route.route_layer(from_fn(check)));
        self.describe(method, path, operation);
        self
    }

    fn describe(&mut self, method: Method, path: &str, operation: Operation) {
        self.described.push(Described {
            method,
            path: path.to_owned(),
            operation,
        });
    }
}
