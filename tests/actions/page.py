"""Asks the program from within a page, as the page itself does."""

from __future__ import annotations

import base64
import json
from typing import Any

from playwright.sync_api import Page

from .driving import Ask

CLIENT = {"X-Mikas-Client": "tester-0001", "X-Mikas-Name": "Me"}

WITH_FETCH = """async ([method, address, headers, body]) => {
  const bytes = body === null ? null : Uint8Array.from(atob(body), (it) => it.charCodeAt(0))
  const answer = await fetch(address, { method, headers, body: bytes })
  return [answer.status, (await answer.bytes()).toBase64()]
}"""
"""On a desktop: the program is what has served the page."""

KEEP_WORKERS = """{
  const Plain = Worker
  window.workers = {}
  window.asked = 1e9
  window.Worker = class extends Plain {
    constructor(url, options) {
      super(url, options)
      workers[options.name.split(" ")[0]] = this // behind it is how it reaches the cable
    }
  }
}"""
"""On the site, before its scripts: the program is in workers, which are found by their names."""

BY_MESSAGES = r"""([method, address, headers, body]) => new Promise((done) => {
  // As web/src/site/program/whoAnswers.ts: the reader gets what only reads recordings.
  const [path] = address.split("?")
  const last = /^(rows|find|faults|causes|file|export|report|tests)$/
  const [, first, , below] = path.split("/")
  const read = first === "recordings" && (below === undefined || last.test(below))
  const log = first === "foreign-logs"
  const trial = path === "api/channels/try" && atob(body).includes('"recording"')
  const reads = log || trial || (method === "GET" && (read || /[?&]recording=/.test(address)))
  const worker = (reads && workers.reader) || workers.line
  const id = ++asked, parts = []
  let status = 0
  worker.addEventListener("message", async function hear({ data }) {
    if (data.id !== id) return
    if (data.kind === "head") status = data.status
    if (data.kind === "body") parts.push(data.data)
    if (data.kind !== "end" && data.kind !== "failed") return
    worker.removeEventListener("message", hear)
    const whole = new Blob(data.kind === "end" ? parts : [data.message])
    done([status, (await whole.bytes()).toBase64()])
  })
  const bytes = body === null ? null : Uint8Array.from(atob(body), (it) => it.charCodeAt(0)).buffer
  worker.postMessage({
    kind: "request", id, method, path: `/${address}`, headers: Object.entries(headers), body: bytes,
  })
})"""
"""On the site: as the page asks its workers. The service worker hands on nothing but GET."""


def asking(page: Page, way: str) -> Ask:
    """Return what sends requests from `page`. `way`: one of those above."""

    def ask(method: str, address: str, body: Any) -> tuple[int, bytes]:
        kind = "application/octet-stream" if isinstance(body, bytes) else "application/json"
        headers = CLIENT if body is None else CLIENT | {"Content-Type": kind}
        raw = body if isinstance(body, bytes) or body is None else json.dumps(body).encode()
        given = None if raw is None else base64.b64encode(raw).decode()
        status, answer = page.evaluate(way, [method, address, headers, given])
        return status, base64.b64decode(answer)

    return ask
