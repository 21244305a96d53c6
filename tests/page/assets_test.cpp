#include "voxelserver/serve/page/assets.hpp"

#include <string>

#include "tests/catch.hpp"

using terravox::page::Asset;

TEST_CASE("the program holds the files of the web page, whole", "[page]") {
    struct Case {
        const char *path, *content_type, *begin, *end;
    };
    const Case c = GENERATE(values<Case>({
        {"index.html", "text/html; charset=utf-8", "<!doctype html>\n", "</html>\n"},
        {"app.js", "text/javascript; charset=utf-8", "", "\n"},
        {"app.css", "text/css; charset=utf-8", "", "}\n"},
        {"viewer.html", "text/html; charset=utf-8", "<!doctype html>\n", "</html>\n"},
        {"viewer.js", "text/javascript; charset=utf-8", "", "\n"},
        {"worker.js", "text/javascript; charset=utf-8", "", "\n"},
        {"viewer.css", "text/css; charset=utf-8", "", "}\n"},
        {"licences.txt", "text/plain; charset=utf-8", "This page holds parts of these packages.\n",
         "\n"},
    }));
    DYNAMIC_SECTION(c.path) {
        const Asset* asset = terravox::page::find(c.path);
        REQUIRE(asset != nullptr);
        CHECK(asset->path == c.path);
        CHECK(asset->content_type == c.content_type);
        CHECK(asset->bytes.size() > 500);
        CHECK(asset->bytes.substr(0, std::string(c.begin).size()) == c.begin);
        CHECK(asset->bytes.substr(asset->bytes.size() - std::string(c.end).size()) == c.end);
    }
}

TEST_CASE("the pages refer to their other files, and no other is found", "[page]") {
    const auto refers = [](const char* page, const std::string& to) {
        return terravox::page::find(page)->bytes.find("\"" + to + "\"") != std::string::npos;
    };
    for (const char* part : {"app.js", "app.css", "licences.txt"})
        CHECK(refers("index.html", std::string("page/") + part));
    for (const char* part : {"viewer.js", "viewer.css"})
        CHECK(refers("viewer.html", std::string("viewer/") + part));
    for (const char* path :
         {"", "/", "index", "page/app.js", "../index.html", "app.js.map", "APP.JS"})
        CHECK(terravox::page::find(path) == nullptr);
}

TEST_CASE("the program holds what the viewer needs of materials and the sky", "[page]") {
    for (const std::string_view file : terravox::page::kViewerFiles)
        CHECK(terravox::page::find(file) != nullptr);
    const std::string_view appearance = terravox::page::default_appearance();
    CHECK(appearance.substr(0, 3) == "\x1f\x8b\x08");  // gzip
    CHECK(appearance.size() > 100'000);
}
