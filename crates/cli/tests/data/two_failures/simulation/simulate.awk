# awk -v seed=NUMBER -v out=FILE -f THIS PARAMETERS
!/^#/ { v[$1] = $2 }
END {
  x = (seed % 2147483000) * 1009 % 2147483647 + 17; x = x % 2147483646 + 1;
  for (i = 0; i < 20; i++) x = (48271 * x) % 2147483647;
  u = x / 2147483647;
  print "time [s],phase" > out; print "0,start" > out;
  end = u < v["slip"] ? "slip" : u < v["slip"] + v["drop"] ? "drop" : "done";
  print v["duration"] "," end > out;
}
