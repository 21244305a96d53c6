#include "raytracer/farm/cluster/template.hpp"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::cluster;
using terravox::test::contains;

namespace {

/// A folder of data files with one template.
class Templates {
public:
    Templates(const std::string& name, const std::string& text) {
        const auto file = m_folder.path() / "cluster" / (name + ".in");
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file) << text;
        std::ofstream(m_folder.path() / "materials.toml");  // by which such a folder is known
        if (const char* before = std::getenv(kVariable))
            m_before = before;
        ::setenv(kVariable, m_folder.path().c_str(), 1);
    }
    ~Templates() {
        if (m_before)
            ::setenv(kVariable, m_before->c_str(), 1);
        else
            ::unsetenv(kVariable);
    }
    Templates(const Templates&) = delete;
    Templates& operator=(const Templates&) = delete;

private:
    static constexpr const char* kVariable = "TERRAVOX_CONFIG";
    test::TemporaryFolder m_folder;
    std::optional<std::string> m_before;
};

}  // namespace

TEST_CASE("names of a template become quoted words, numbers and lines", "[cluster][template]") {
    const Templates templates("a/b.sh",
                              "{{# of no use to a reader: {{none}} }}\n"
                              "a={{word}}{{number}} # {{plain}} {{Task.Param}} {{word}}\n"
                              "  {{list}}\n"
                              "--{{none}}\n"
                              "{{body}}\n");
    CHECK(fill("a/b.sh", {{"word", "it's"},
                          {"number", 12},
                          {"plain", Value::plain("it's {{word}}")},
                          {"list", std::vector<std::string>{"a", "b c", "\n"}},
                          {"none", Value::plain_list({})},
                          {"body", Value::plain("x\ny\n")}}) ==
          "a='it'\\''s'12 # it's {{word}} {{Task.Param}} 'it'\\''s'\n"
          "  a\n"
          "  'b c'\n"
          "  $'\\012'\n"
          "x\n"
          "y\n");
}

TEST_CASE("a template of JSON stays JSON, whatever the words are", "[cluster][template]") {
    const Templates templates("engine/b.json",
                              "{{# a list, and a field that is there or not }}\n"
                              "{\"words\": [\n"
                              "  {{words}}\n"
                              "]\n"
                              ", \"more\": {{more}}\n"
                              "}\n");
    const std::vector<std::string> words{"\"", "}}", "\n\\", "\u00fc"};
    const auto filled = [&](const std::vector<std::string>& more) {
        return nlohmann::json::parse(fill("engine/b.json", {{"words", words}, {"more", more}}));
    };
    CHECK(filled({"x"}) == nlohmann::json{{"words", words}, {"more", "x"}});
    CHECK(filled({}) == nlohmann::json{{"words", words}});
    CHECK_THROWS_WITH(filled({"\xff"}),
                      "cluster engine: an argument is no UTF-8; allowed: UTF-8, "
                      "which JSON is written in");
}

TEST_CASE("a template with other names than there are values is refused", "[cluster][template]") {
    const Templates templates("a/b.sh", "{{one}} {{two}}\n");
    const Values two{{"one", 1}, {"two", 2}};
    CHECK(fill("a/b.sh", two) == "1 2\n");
    CHECK_THROWS_WITH(fill("a/b.sh", {{"one", 1}}),
                      "fill the template config/cluster/a/b.sh.in: it has {{two}}; allowed: all of "
                      "one, and no others");
    CHECK_THROWS_WITH(fill("a/b.sh", {{"one", 1}, {"three", 3}, {"two", 2}}),
                      "fill the template config/cluster/a/b.sh.in: it has no {{three}}; allowed: "
                      "all of one, three, two, and no others");
    const std::vector<std::string> list{"a", "b"};
    CHECK_THROWS_WITH(fill("a/b.sh", {{"one", list}, {"two", std::vector<std::string>{"a"}}}),
                      contains("two lists"));
    CHECK_THROWS_WITH(fill("a/none.sh", two), contains("it cannot be read"));
}
