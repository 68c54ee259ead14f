"""Writes random rosbag2 databases with the SQLite library into a folder, and beside each what is in it.

    python random_databases.py FOLDER COUNT SEED

`N.txt` has a line for each message of `N.db3`: topic, time, data in hexadecimal, in the order of the row ids.
"""

import random
import shutil
import sqlite3
import sys
from pathlib import Path

folder, count = Path(sys.argv[1]), int(sys.argv[2])
dice = random.Random(int(sys.argv[3]))


def fill(connection):
    if dice.random() < 0.5:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute(f"PRAGMA wal_autocheckpoint = {dice.choice([0, 3, 100])}")
    connection.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL)")
    columns = ["topic_id INTEGER NOT NULL", '"timestamp" INTEGER NOT NULL', "data BLOB NOT NULL"]
    if dice.random() < 0.3:
        columns.insert(dice.randrange(4), "[note, (to, self)] TEXT DEFAULT ','")
    connection.execute(f"CREATE TABLE messages(id INTEGER PRIMARY KEY, {', '.join(columns)})")
    connection.execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)")
    topics = dice.randrange(1, 300)
    for topic in range(topics):
        name = f"/t{topic}ä" + "x" * dice.choice([0, 0, 0, 3000])
        connection.execute("INSERT INTO topics(name, type) VALUES(?, ?)", (name, "std_msgs/msg/Bool"))
    for row in range(dice.choice([0, 1, 10, 300, 3000])):
        size = dice.choice([0, 1, 20, 40, dice.randrange(1200), dice.randrange(20_000) if dice.random() < 0.05 else 5])
        time = dice.choice([0, 1, -1, 127, -129, 2**31, 2**40, -(2**62), 1_700_000_000_000_000_000 + row])
        values = (dice.randrange(topics) + 1, time, dice.randbytes(size))
        connection.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", values)
        if dice.random() < 0.01:
            connection.commit()
        if dice.random() < 0.01:
            connection.execute("DELETE FROM messages WHERE id % 7 = 3")
    connection.commit()


for number in range(count):
    live = folder / "live.db3"
    for path in folder.glob("live.db3*"):
        path.unlink()
    connection = sqlite3.connect(live)
    connection.execute(f"PRAGMA page_size = {dice.choice([512, 1024, 4096, 8192, 65536])}")
    connection.execute(f"PRAGMA auto_vacuum = {dice.choice([0, 0, 1, 2])}")
    connection.execute(f"PRAGMA encoding = '{dice.choice(['UTF-8', 'UTF-16le', 'UTF-16be'])}'")
    fill(connection)
    # Copied while it is open, so that what is only in the log stays there.
    shutil.copyfile(live, folder / f"{number}.db3")
    if (folder / "live.db3-wal").exists():
        shutil.copyfile(folder / "live.db3-wal", folder / f"{number}.db3-wal")
    query = "SELECT name, timestamp, data FROM messages JOIN topics ON topics.id = topic_id ORDER BY messages.id"
    lines = [f"{name} {time} {data.hex()}\n" for name, time, data in connection.execute(query)]
    (folder / f"{number}.txt").write_text("".join(lines), "utf-8")
    connection.close()
