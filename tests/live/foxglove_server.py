"""Serves numbered messages over the Foxglove WebSocket, with the server that the protocol's authors publish.

It begins to count when told so by a line on its input, so that a client can have subscribed before.
"""

import argparse
import os
import time

import foxglove
from foxglove import Channel


def say_pid():
    """Tells whoever wants to kill this process its number."""
    if path := os.environ.get("LIVE_PID_FILE"):
        with open(path, "w") as file:
            file.write(str(os.getpid()))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--rate", type=float, required=True, help="messages a second")
    parser.add_argument("--seconds", type=float, required=True)
    options = parser.parse_args()
    server = foxglove.start_server(name="peer", host="0.0.0.0", port=options.port)
    say_pid()
    number_type = {"type": "number"}
    schema = {"type": "object", "properties": {"n": {"type": "integer"}, "after": number_type}}
    channel = Channel("/count", schema=schema)
    print("ready", flush=True)
    input()
    count = round(options.rate * options.seconds)
    start = time.monotonic()
    for number in range(1, count + 1):
        channel.log({"n": number, "after": number + 0.001})
        wait = start + number / options.rate - time.monotonic()
        if wait > 0:
            time.sleep(wait)
    print(f"sent {count}", flush=True)
    input()
    server.stop()


if __name__ == "__main__":
    main()
