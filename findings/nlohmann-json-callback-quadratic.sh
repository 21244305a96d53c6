#!/usr/bin/env bash
# nlohmann/json 3.11.2 (Debian 12, nlohmann-json3-dev 3.11.2-2): parsing with a callback takes time
# that grows with the square of how many objects an array holds, even when the callback keeps all.
#
# A good guess: a callback costs one call for each event. What happens: at the end of each object
# the parser looks through all elements that the array around it has so far for one that was
# discarded, and finds none. A GeoJSON file of 80,000 points is read in well under a second without
# a callback and in many seconds with one, whatever the callback does (limiting depth, for example).
#
# The ratio of CPU times for 40,000 and for 10,000 small objects tells: 4 is linear, 16 is square.
# Seen: 4.9 without a callback, 16.4 with one. Output:
#   without a callback: linear
#   with a callback: more than linear
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get -qq download nlohmann-json3-dev=3.11.2-2 2>/dev/null
dpkg-deb --extract nlohmann-json3-dev_*.deb .
cat >parse.cpp <<'CPP'
#include <cstdio>
#include <ctime>
#include <string>

#include <nlohmann/json.hpp>

static_assert(NLOHMANN_JSON_VERSION_MAJOR == 3 && NLOHMANN_JSON_VERSION_MINOR == 11);

double seconds(int objects, bool with_callback) {
    std::string text = "[";
    for (int i = 0; i < objects; ++i)
        text += i == 0 ? "{\"a\":1}" : ",{\"a\":1}";
    text += "]";
    nlohmann::json::parser_callback_t keep_all;
    if (with_callback)
        keep_all = [](int, nlohmann::json::parse_event_t, nlohmann::json&) { return true; };
    const std::clock_t begin = std::clock();
    const auto size = nlohmann::json::parse(text, keep_all).size();
    return size == static_cast<std::size_t>(objects)
               ? double(std::clock() - begin) / CLOCKS_PER_SEC
               : -1;
}

int main() {
    for (const bool with_callback : {false, true}) {
        const double ratio = seconds(40000, with_callback) / seconds(10000, with_callback);
        std::fprintf(stderr, "ratio %.1f\n", ratio);
        std::printf("%s a callback: %s\n", with_callback ? "with" : "without",
                    ratio > 8 ? "more than linear" : "linear");
    }
}
CPP
c++ -std=c++17 -O2 -I usr/include parse.cpp -o parse
./parse | tee seen
diff - seen <<'SEEN'
without a callback: linear
with a callback: more than linear
SEEN
