#include "voxelserver/make/voxelize/points/class_table.hpp"

#include <fstream>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::voxelize;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
using voxel::Material;
namespace fs = std::filesystem;

TEST_CASE("all class tables load, and define the standard's classes", "[voxelserver][classes]") {
    int tables = 0;
    for (const auto& entry : fs::directory_iterator(util::config_dir() / "classes")) {
        ++tables;
        INFO(entry.path().string());
        const ClassTable table = load_class_table(entry.path().stem().string());
        CHECK(table.meaning[2].role == Role::kGround);
        CHECK(table.meaning[6].role == Role::kBuilding);
        CHECK(table.meaning[9].role == Role::kWater);
        for (const ClassMeaning& m : table.meaning) {
            // What is not dropped is seen.
            if (m.role != Role::kDrop && m.role != Role::kSurface)
                CHECK(m.material != Material::kAir);
            if (!m.known)
                CHECK((m.role == Role::kSurface && m.tiers));
        }
    }
    CHECK(tables >= 9);
}

TEST_CASE("sources differ from the standard where they say so", "[voxelserver][classes]") {
    struct Case {
        const char* name;
        int code;
        Role role;
        Material material;
    };
    const auto c = GENERATE(values<Case>({
        {"asprs", 7, Role::kDrop, Material::kAir},
        {"asprs", 17, Role::kBridge, Material::kBridge},
        {"asprs", 10, Role::kGround, Material::kRail},
        {"asprs", 11, Role::kGround, Material::kRoad},
        {"asprs", 64, Role::kSurface, Material::kAir},
        {"si-clss", 7, Role::kObject, Material::kConcrete},
        {"si-clss", 8, Role::kBuilding, Material::kRoof},
        {"ch-swisstopo", 3, Role::kVegetation, Material::kHighVegetation},
        {"nl-ahn", 26, Role::kBridge, Material::kBridge},
        {"de-nw", 20, Role::kSurface, Material::kAir},
        {"fr-lidarhd", 66, Role::kGround, Material::kGround},
        {"fr-lidarhd", 65, Role::kDrop, Material::kAir},
    }));
    DYNAMIC_SECTION(c.name << " " << c.code) {
        const ClassTable table = load_class_table(c.name);
        CHECK(table.meaning[static_cast<std::size_t>(c.code)].role == c.role);
        CHECK(table.meaning[static_cast<std::size_t>(c.code)].material == c.material);
    }
    const ClassTable marked = load_class_table("asprs", Unnamed::kMarked);
    CHECK(marked.meaning[64].role == Role::kObject);
    CHECK(marked.meaning[255].material == Material::kUnknown);
    CHECK(load_class_table("nl-ahn").crs == "EPSG:28992");
    CHECK(load_class_table("ch-swisstopo").meaning[3].tiers);
    CHECK_FALSE(load_class_table("asprs").crs);
}

TEST_CASE("a table of one's own extends one next to it, or one that ships with the program",
          "[voxelserver][classes]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "base.toml")
        << "crs = \"EPSG:3794\"\n[class]\n5 = { role = \"object\", material = \"tower\" }\n200 = { "
           "role = \"drop\" }\n";
    const auto extended = [&](const std::string& base) {
        const auto file = folder.path() / "mine.toml";
        std::ofstream(file) << "extends = \"" << base
                            << "\"\n[class]\n200 = { role = \"water\", material = \"water\" }\n0 = "
                               "{ role = \"surface\" }\n";
        return load_class_table(file.string());
    };
    const ClassTable table = extended("base");
    CHECK(table.crs == "EPSG:3794");
    CHECK(table.meaning[5].material == Material::kTower);
    CHECK(table.meaning[200].role == Role::kWater);
    CHECK(table.meaning[0].tiers);
    CHECK_FALSE(table.meaning[7].known);
    CHECK(extended("nl-ahn").crs == "EPSG:28992");
    CHECK(extended("nl-ahn").meaning[26].material == Material::kBridge);
}

TEST_CASE("an unknown table is refused with the list of those there are",
          "[voxelserver][classes]") {
    const std::string id = GENERATE("", "asprs2", "../classes/asprs", "ASPRS", "/etc/passwd");
    INFO("'" << id << "'");
    CHECK_THROWS_AS(load_class_table(id), util::UsageError);
    CHECK_THROWS_WITH(load_class_table(id),
                      contains("'" + id + "'") && contains("asprs, ch-swisstopo"));
    CHECK_THROWS_AS(load_class_table("/no/such/table.toml"), util::UsageError);
    CHECK_THROWS_WITH(load_class_table("/no/such/table.toml"), contains("/no/such/table.toml"));
}

TEST_CASE("a table that cannot be is refused, naming file, field, value and what is allowed",
          "[voxelserver][classes]") {
    struct Case {
        const char* name;
        std::string text;
        std::string said;
    };
    const auto c = GENERATE(values<Case>({
        {"code too high", "[class]\n256 = { role = \"drop\" }", "[class.256]; allowed: 0 to 255"},
        {"code in words", "[class]\nground = { role = \"drop\" }",
         "[class.ground]; allowed: 0 to 255"},
        {"negative code", "[class]\n-1 = { role = \"drop\" }", "[class.-1]; allowed: 0 to 255"},
        {"unknown role", "[class]\n2 = { role = \"floor\" }",
         "role = 'floor'; allowed: drop, ground, water"},
        {"no role", "[class]\n2 = { material = \"ground\" }", "role = ''; allowed"},
        {"unknown material", "[class]\n2 = { role = \"ground\", material = \"cheese\" }",
         "material = 'cheese'"},
        {"no material", "[class]\n2 = { role = \"ground\" }", "material = 'air'"},
        {"no table", "[class]\n2 = \"ground\"", "[class.2] is not a table"},
        {"no TOML", "[class\n", "line 1"},
        {"an unknown section", "[clas]\n2 = { role = \"drop\" }",
         "clas is no field; allowed: title, extends, crs, class, meant"},
        {"an empty unknown section", "[foo]",
         "foo is no field; allowed: title, extends, crs, class, meant"},
        {"an unknown field of a class", "[class]\n2 = { role = \"drop\", height = 1 }",
         "[class.2] height is no field; allowed: role, material, tiers"},
        {"classes that are no table", "class = 2", "class is no table"},
        {"a CRS that is a number", "crs = 3794", "crs is no text"},
        {"a base that is a number", "extends = 1", "extends is no text"},
        {"tiers that are no flag", "[class]\n2 = { role = \"surface\", tiers = 1 }",
         "[class.2] tiers is not true or false"},
        {"unknown base", "extends = \"nothing\"\n",
         "extends = 'nothing'; allowed: a table next to it, or asprs, ch-swisstopo"},
        {"no systems", "[meant]\nwith = [3]", "[meant] crs is no list of texts"},
        {"a system that is a number", "[meant]\ncrs = [2154]", "[meant] crs is no list of texts"},
        {"three edges", "[meant]\ncrs = [\"EPSG:2154\"]\nextent = [1, 2, 3]",
         "[meant] extent is no list of four numbers"},
        {"a class too high", "[meant]\ncrs = [\"EPSG:2154\"]\nwith = [256]",
         "[meant] with = 256; allowed: 0 to 255"},
        {"a class alone", "[meant]\ncrs = [\"EPSG:2154\"]\nwithout = 3",
         "[meant] without is no list of classes"},
        {"itself", "extends = \"bad\"\n", "circular"},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        const auto file = folder.path() / "bad.toml";
        std::ofstream(file) << c.text;
        CHECK_THROWS_AS(load_class_table(file.string()), util::Error);
        CHECK_THROWS_WITH(load_class_table(file.string()),
                          contains(file.string()) && contains(c.said));
    }
}

TEST_CASE("tables are found by the codes that they name", "[voxelserver][classes]") {
    const auto of = [](std::initializer_list<std::size_t> codes) {
        std::bitset<256> out;
        for (const std::size_t c : codes)
            out.set(c);
        return tables_that_name(out);
    };
    CHECK(of({64, 67}) == "fr-lidarhd");
    CHECK(of({26}) == "nl-ahn");
    CHECK(of({26, 64}).empty());
    CHECK_THAT(of({2, 6}), contains("asprs, ch-swisstopo"));
}
