#include "voxelserver/make/worlds/open/open_world.hpp"

#include <filesystem>

#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/make/worlds/archive/archive_kind.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/make/worlds/luanti/luanti_world.hpp"
#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"
#include "voxelserver/make/worlds/procedural/procedural_world.hpp"
#include "voxelserver/make/worlds/remote/remote_world.hpp"

using namespace terravox;
using namespace terravox::worlds;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
using terravox::test::write_content;
namespace fs = std::filesystem;

namespace {

/// An input with the folder's path in place of HERE.
std::string placed(std::string input, const fs::path& folder) {
    const std::string mark = "HERE";
    if (input.starts_with(mark))
        input.replace(0, mark.size(), folder.string());
    return input;
}

}  // namespace

TEST_CASE("each input has one kind", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    const fs::path& at = folder.path();
    write_content(at / "named.LAZ", "nothing that could be read");
    write_content(at / "points.bin", "LASF and more");
    write_content(at / "squares" / "a.laz", "");
    write_content(at / "store" / "fishnet.gpkg", "");
    write_content(at / "game" / "level.dat", "");
    write_content(at / "game" / "region" / "r.0.0.mca", "");
    write_content(at / "luanti" / "world.mt", "");
    write_content(at / "luanti" / "map.sqlite", "");
    write_content(at / "both" / "world.mt", "");
    write_content(at / "both" / "level.dat", "");
    struct Case {
        const char* name;
        std::string input;  ///< HERE stands for the folder: each case has one of its own
        const WorldKind* kind;
    };
    const auto c = GENERATE(values<Case>({
        {"an address", "http://127.0.0.1:1/", &worlds::kServerKind},
        {"an address with TLS", "https://voxels.example", &worlds::kServerKind},
        {"an archive's address", "http://host/place.tvx", &kRemoteArchiveKind},
        {"noise", "generated", &worlds::kProceduralKind},
        {"noise with a seed", "generated:42", &worlds::kProceduralKind},
        {"points by their name", "HERE/named.LAZ", &kLidarKind},
        {"points by their first bytes", "HERE/points.bin", &kLidarKind},
        {"a folder of points", "HERE/squares", &kLidarKind},
        {"a store", "HERE/store", &kStoreKind},
        {"a game's folder", "HERE/game", &worlds::kMinecraftKind},
        {"a Luanti world", "HERE/luanti", &worlds::kLuantiKind},
        {"a Luanti map", "HERE/luanti/map.sqlite", &worlds::kLuantiKind},
        {"a game's folder with a Luanti setting", "HERE/both", &worlds::kMinecraftKind},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(&find_kind(placed(c.input, at)) == c.kind);
    }
}

TEST_CASE("a file comes before a world of its name", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    const fs::path before = fs::current_path();
    fs::current_path(folder.path());
    write_content(folder.path() / "generated", "LASF");
    const std::string input = "generated";
    const WorldKind& kind = find_kind(input);
    fs::current_path(before);
    CHECK(&kind == &kLidarKind);
}

TEST_CASE("what is no world is refused with all that is allowed", "[voxelserver][worlds]") {
    const TemporaryFolder folder;
    write_content(folder.path() / "text.txt", "no world");
    fs::create_directories(folder.path() / "empty");
    struct Case {
        const char* name;
        std::string input;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing", "HERE/none", "does not exist"},
        {"a text", "HERE/text.txt", "is of no known kind"},
        {"an empty folder", "HERE/empty", "holds no world"},
    }));
    DYNAMIC_SECTION(c.name) {
        const std::string input = placed(c.input, folder.path());
        CHECK_THROWS_WITH(find_kind(input), contains(input) && contains(c.said) &&
                                                contains("; allowed: " + allowed_inputs()));
    }
}

TEST_CASE("inputs and options that do not suit a kind are refused", "[voxelserver][worlds]") {
    struct Case {
        const char* name;
        std::vector<std::string> inputs;
        bool has_orthophoto;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing", {}, false, "nothing given"},
        {"two kinds", {"generated", "http://127.0.0.1:1"}, false, "allowed: inputs of one kind"},
        {"two of one", {"generated:1", "generated:2"}, false, "allowed: one of these"},
        {"images of noise", {"generated"}, true, "--ortho with a generated world"},
        {"images of a server", {"http://127.0.0.1:1"}, true, "the server's own command line"},
        {"a word for a seed", {"generated:x"}, false, "the seed is 'x'"},
        {"no seed", {"generated:"}, false, "the seed is ''"},
    }));
    DYNAMIC_SECTION(c.name) {
        worlds::WorldOptions options;
        options.inputs = c.inputs;
        if (c.has_orthophoto)
            options.orthophotos = {"photo.tif"};
        util::StageTimes times;
        CHECK_THROWS_WITH(worlds::open_world(options, times), contains(c.said));
    }
}
