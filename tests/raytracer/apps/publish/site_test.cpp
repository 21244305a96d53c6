#include "raytracer/apps/publish/site.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

void write(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

publish::SiteFacts some_facts() {
    publish::SiteFacts facts;
    facts.title = "A & <B>";
    facts.archive = {{"place.tvx", 5}};
    facts.views = {{"Start", {1, 2, 3}, {4, 5, 6}, 40}};
    return facts;
}

}  // namespace

TEST_CASE("a site leaves nothing of an earlier one, and files of others alone", "[publish]") {
    const TemporaryFolder folder;
    for (const char* name : {"place.tvx", "place-0001.part", "place-0002.part", "preview.jpg",
                             "place-notes.part", "place-12.part", "other.tvx"})
        write(folder.path() / name, "x");
    publish::SiteFacts facts = some_facts();
    facts.archive = {{"place-0001.part", 1}};
    publish::write_site(folder.path(), facts);
    CHECK_FALSE(fs::exists(folder.path() / "place.tvx"));
    CHECK(fs::exists(folder.path() / "place-0001.part"));
    CHECK_FALSE(fs::exists(folder.path() / "place-0002.part"));
    CHECK_FALSE(fs::exists(folder.path() / "preview.jpg"));
    for (const char* name : {"place-notes.part", "place-12.part", "other.tvx"})
        CHECK(fs::exists(folder.path() / name));
}

TEST_CASE("an archive elsewhere is at an address that a page may read", "[publish]") {
    using publish::check_archive_url;
    for (const char* url : {"https://files.example/a.tvx", "https://files.example:8443/a?k=1:2@3",
                            "valley.tvx", "../places/valley.tvx", "/places/valley.tvx?v=2"}) {
        INFO(url);
        CHECK_NOTHROW(check_archive_url(url));
    }
    const std::string long_path = "a/" + std::string(publish::kMaxText_bytes, 'a');
    for (const std::string& url :
         {std::string(), std::string("http://files.example/a.tvx"), std::string("https://"),
          std::string("https:///a.tvx"), std::string("https://me:secret@files.example/a.tvx"),
          std::string("//files.example/a.tvx"), std::string("file:///a.tvx"),
          std::string("javascript:alert(1)"), std::string("a.tvx#part"), std::string("a b.tvx"),
          std::string("a\\b.tvx"), std::string("a\n.tvx"), std::string("\xc3\xa9.tvx"),
          long_path}) {
        INFO(url);
        CHECK_THROWS_AS(check_archive_url(url), util::UsageError);
    }
}

TEST_CASE("a site is known by its place.json, which may be anybody's", "[publish]") {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "place.json";
    CHECK_FALSE(publish::read_site(folder.path()));
    publish::SiteFacts facts = some_facts();
    facts.archive = {{"https://files.example/a.tvx", 0}};
    publish::write_site(folder.path(), facts);
    REQUIRE(publish::read_site(folder.path()));
    CHECK(publish::read_site(folder.path())->archive_url == "https://files.example/a.tvx");
    for (const std::string& text :
         {std::string(), std::string("[1]"), std::string(R"({"version": 1, "views": []})"),
          std::string(R"({"version": 1, "views": {}, "archive": []})"), std::string(1 << 19, '['),
          std::string(1 << 21, ' ') + publish::place_json(facts)}) {
        INFO(text.substr(0, 60));
        write(file, text);
        CHECK_FALSE(publish::read_site(folder.path()));
    }
    write(folder.path() / "elsewhere.json", publish::place_json(facts));
    fs::remove(file);
    fs::create_symlink("elsewhere.json", file);
    CHECK_FALSE(publish::read_site(folder.path()));
}

TEST_CASE("the origin of an archive elsewhere fits into a policy", "[publish]") {
    CHECK(publish::to_origin("https://files.example:8443/a.tvx?x") == "https://files.example:8443");
    for (const char* url :
         {"place.tvx", "../place.tvx", "http://files.example/a.tvx", "https://a;script-src/b",
          "https://a,b/c", "https://*/a", "https://'unsafe-eval'/a", ""}) {
        INFO(url);
        CHECK(publish::to_origin(url).empty());
    }
}

TEST_CASE("squares are a file of their own, with their outlines in the CRS", "[publish]") {
    const TemporaryFolder folder;
    publish::SiteFacts facts = some_facts();
    facts.squares = {{"TM_1", 1000, 2000, 2000, 3000}};
    publish::write_site(folder.path(), facts);
    CHECK(nlohmann::json::parse(publish::place_json(facts))["squares"] == "squares.json");
    const auto squares = nlohmann::json::parse(read(folder.path() / "squares.json"));
    const auto& square = squares["features"][0];
    CHECK(square["properties"]["name"] == "TM_1");
    const auto corners = square["geometry"]["coordinates"][0];
    REQUIRE(corners.size() == 5);
    CHECK(corners[0] == nlohmann::json::array({1000.0, 2000.0}));
    CHECK(corners[2] == nlohmann::json::array({2000.0, 3000.0}));
    CHECK(corners[4] == corners[0]);

    facts.squares.clear();
    publish::write_site(folder.path(), facts);
    CHECK_FALSE(fs::exists(folder.path() / "squares.json"));
    CHECK_FALSE(nlohmann::json::parse(publish::place_json(facts)).contains("squares"));
}

TEST_CASE("the page has the title of the place, escaped, and a picture where there is one",
          "[publish]") {
    publish::SiteFacts facts = some_facts();
    CHECK(publish::index_html(facts).find("<title>A &amp; &lt;B&gt;</title>") != std::string::npos);
    CHECK(publish::index_html(facts).find("og:image") == std::string::npos);
    facts.has_preview = true;
    CHECK(publish::index_html(facts).find("og:image") != std::string::npos);
    const auto place = nlohmann::json::parse(publish::place_json(facts));
    CHECK(place["title"] == facts.title);
    CHECK(place["views"][0]["target"] == nlohmann::json({4, 5, 6}));
    CHECK_FALSE(place["views"][0].contains("frame"));
    facts.views[0].frame = voxel::VoxelBounds{{-1, -2, -3}, {1, 2, 3}};
    CHECK(nlohmann::json::parse(publish::place_json(facts))["views"][0]["frame"] ==
          nlohmann::json{{"min", {-1, -2, -3}}, {"max", {1, 2, 3}}});
}

TEST_CASE("a link at the name of a file of a site is replaced, not followed", "[publish]") {
    const TemporaryFolder folder;
    write(folder.path() / "precious", "as it was");
    const fs::path site = folder.path() / "site";
    fs::create_directory(site);
    fs::create_symlink("../precious", site / publish::kSitePlace);
    fs::create_symlink("../precious", site / publish::kSitePage);
    publish::write_site(site, some_facts());
    CHECK(read(folder.path() / "precious") == "as it was");
    CHECK(fs::is_regular_file(fs::symlink_status(site / publish::kSitePage)));
}
