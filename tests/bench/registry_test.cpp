#include "common/util/error.hpp"
#include "tests/bench/bench.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::bench;

namespace {

Entry named(const std::string& name) {
    Entry out;
    out.name = name;
    return out;
}

const Registration kLast([] { return std::vector{named("walk/a")}; });
const Registration kFirst([] { return std::vector{named("boxes/b"), named("boxes/a")}; });

std::vector<std::string> list_names(const std::vector<Entry>& entries) {
    std::vector<std::string> out;
    for (const Entry& entry : entries)
        out.push_back(entry.name);
    return out;
}

}  // namespace

TEST_CASE("entries are listed by name, whoever registered first", "[bench][registry]") {
    CHECK(list_names(registered_entries()) ==
          std::vector<std::string>{"boxes/a", "boxes/b", "walk/a"});
}

TEST_CASE("beginnings of names select entries, each once", "[bench][registry]") {
    const auto all = registered_entries();
    CHECK(select_entries(all, {}).size() == 3);
    CHECK(list_names(select_entries(all, {"walk/a"})) == std::vector<std::string>{"walk/a"});
    CHECK(list_names(select_entries(all, {"boxes/b", "boxes/"})) ==
          std::vector<std::string>{"boxes/a", "boxes/b"});
}

TEST_CASE("a long entry runs only when its whole name is given", "[bench][registry]") {
    auto all = registered_entries();
    Entry slow = named("walk/slow");
    slow.only_by_name = true;
    all.push_back(slow);
    CHECK(select_entries(all, {}).size() == 3);
    CHECK(list_names(select_entries(all, {"walk"})) == std::vector<std::string>{"walk/a"});
    CHECK(list_names(select_entries(all, {"walk"}, true)) ==
          std::vector<std::string>{"walk/a", "walk/slow"});
    CHECK(list_names(select_entries(all, {"walk/slow"})) == std::vector<std::string>{"walk/slow"});
}

TEST_CASE("a beginning that no entry has is wrong usage", "[bench][registry]") {
    CHECK_THROWS_AS(select_entries(registered_entries(), {"boxes", "nothing"}), util::UsageError);
    CHECK_THROWS_WITH(select_entries(registered_entries(), {"nothing"}),
                      test::contains("'nothing'"));
}
