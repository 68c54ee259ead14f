"""Serves numbered messages over the Foxglove WebSocket, with the server that the protocol's authors publish.

It begins to count when told so by a line on its input, so that a client can have subscribed before.
"""

import argparse
import time

import foxglove
from foxglove import Channel


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--rate", type=float, required=True, help="messages a second")
    parser.add_argument("--seconds", type=float, required=True)
    options = parser.parse_args()
    server = foxglove.start_server(name="peer", host="0.0.0.0", port=options.port)
    schema = {"type": "object", "properties": {"n": {"type": "integer"}}}
    channel = Channel("/count", schema=schema)
    print("ready", flush=True)
    input()
    count = round(options.rate * options.seconds)
    start = time.monotonic()
    for number in range(1, count + 1):
        channel.log({"n": number})
        wait = start + number / options.rate - time.monotonic()
        if wait > 0:
            time.sleep(wait)
    print(f"sent {count}", flush=True)
    input()
    server.stop()


if __name__ == "__main__":
    main()
