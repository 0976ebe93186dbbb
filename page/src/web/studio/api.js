// What the page asks its server.

/** An answer that is none. */
export class Refusal extends Error {
  constructor(status, body) {
    super(body?.error?.message ?? `the server answered ${status}`);
    this.status = status;
    this.body = body ?? {};
    this.hint = body?.error?.hint ?? null;
  }
}

export class Api {
  constructor(token) {
    this.token = token;
  }

  /** An answer as JSON. Status 0 where nobody answers. */
  async ask(method, path, body, signal) {
    const response = await this.fetched(method, path, body, signal);
    const text = await response.text();
    let said = null;
    try {
      said = text ? JSON.parse(text) : {};
    } catch {
      said = null;
    }
    if (!response.ok || said === null) throw new Refusal(response.status, said);
    return said;
  }

  async fetched(method, path, body, signal) {
    const headers = { "x-kinfold-token": this.token };
    if (body !== undefined) headers["content-type"] = "application/json";
    try {
      return await fetch(`/api/${path}`, { method, headers, signal, body: body === undefined ? undefined : JSON.stringify(body) });
    } catch (error) {
      if (error.name === "AbortError") throw error;
      throw new Refusal(0, { error: { message: "The studio does not answer." } });
    }
  }

  get(path) {
    return this.ask("GET", path);
  }

  put(path, body) {
    return this.ask("PUT", path, body);
  }

  post(path, body = {}, signal = undefined) {
    return this.ask("POST", path, body, signal);
  }

  async bytes(path) {
    const response = await this.fetched("GET", path);
    if (!response.ok) throw new Refusal(response.status, await response.json().catch(() => null));
    return new Uint8Array(await response.arrayBuffer());
  }

  /** An address for what sends no headers. */
  address(path) {
    return `/api/${path}?token=${encodeURIComponent(this.token)}`;
  }
}
