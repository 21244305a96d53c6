#include "voxelserver/http/index_page.hpp"

#include "tests/catch.hpp"
#include "tests/voxelserver/http/fake_world.hpp"

using namespace terravox;

TEST_CASE("the page escapes what comes from the world", "[voxelserver][http]") {
    test::FakeWorld world;
    const std::string page = http::index_page(world.info());
    CHECK_THAT(page, test::contains("a &lt;fake&gt; &quot;world&quot;"));
    CHECK_THAT(page, test::contains("nobody &amp; nothing"));
    CHECK_THAT(page, test::contains("-256 to 512"));
    CHECK(page.find("<fake>") == std::string::npos);
}

TEST_CASE("the page loads nothing from elsewhere", "[voxelserver][http]") {
    test::FakeWorld world;
    const std::string page = http::index_page(world.info());
    for (const char* outside : {"http://", "https://", "src=", "<script", "@import", "url("}) {
        INFO(outside);
        CHECK(page.find(outside) == std::string::npos);
    }
}
