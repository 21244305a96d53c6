#include <algorithm>
#include <functional>

#include "common/util/error.hpp"
#include "tests/bench/bench.hpp"

namespace terravox::bench {
namespace {

std::vector<std::function<std::vector<Entry>()>>& makers() {
    static std::vector<std::function<std::vector<Entry>()>> list;
    return list;
}

bool begins_with(const std::string& name, const std::string& prefix) {
    return name.compare(0, prefix.size(), prefix) == 0;
}

}  // namespace

// Out of memory before main is no state to go on from: noexcept ends the program.
Registration::Registration(const std::function<std::vector<Entry>()>& make) noexcept {
    makers().push_back(make);
}

std::vector<Entry> registered_entries() {
    std::vector<Entry> out;
    for (const auto& make : makers()) {
        auto some = make();
        std::move(some.begin(), some.end(), std::back_inserter(out));
    }
    // By name: the order of registration is the linker's.
    std::sort(out.begin(), out.end(),
              [](const Entry& a, const Entry& b) { return a.name < b.name; });
    const auto twice = std::adjacent_find(
        out.begin(), out.end(), [](const Entry& a, const Entry& b) { return a.name == b.name; });
    if (twice != out.end())
        throw util::Error("list the entries: two are called " + twice->name);
    return out;
}

std::vector<Entry> select_entries(const std::vector<Entry>& entries,
                                  const std::vector<std::string>& prefixes, bool long_too) {
    for (const std::string& prefix : prefixes)
        if (std::none_of(entries.begin(), entries.end(),
                         [&](const Entry& e) { return begins_with(e.name, prefix); }))
            throw util::UsageError("choose entries: none begins with '" + prefix +
                                   "'; --list shows them");
    std::vector<Entry> out;
    for (const Entry& e : entries) {
        const bool whole = e.only_by_name && !long_too;
        const auto names = [&](const std::string& p) {
            return whole ? e.name == p : begins_with(e.name, p);
        };
        if ((prefixes.empty() && !whole) || std::any_of(prefixes.begin(), prefixes.end(), names))
            out.push_back(e);
    }
    return out;
}

}  // namespace terravox::bench
