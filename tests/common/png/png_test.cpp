#include "common/png/png.hpp"

#include <png.h>

#include <map>
#include <vector>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;

namespace {

/// The texts of a file, as libpng's reader finds them, which also verifies the checksums of chunks.
class Reader {
public:
    explicit Reader(const std::string& bytes) : m_bytes(bytes) {
        m_png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, fail);
        m_info = png_create_info_struct(m_png);
        png_set_read_fn(m_png, this, read);
        png_read_png(m_png, m_info, PNG_TRANSFORM_IDENTITY, nullptr);
    }
    ~Reader() { png_destroy_read_struct(&m_png, &m_info, nullptr); }
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;

    [[nodiscard]] std::map<std::string, std::string> texts() const {
        png_textp first = nullptr;
        int count = 0;
        png_get_text(m_png, m_info, &first, &count);
        std::map<std::string, std::string> out;
        for (int i = 0; i < count; ++i)
            out[first[i].key] = first[i].text;
        return out;
    }
    [[nodiscard]] std::vector<std::uint8_t> samples() const {
        std::vector<std::uint8_t> out;
        png_bytepp rows = png_get_rows(m_png, m_info);
        for (png_uint_32 y = 0; y < png_get_image_height(m_png, m_info); ++y)
            out.insert(out.end(), rows[y], rows[y] + png_get_rowbytes(m_png, m_info));
        return out;
    }

private:
    [[noreturn]] static void fail(png_structp, png_const_charp message) {
        throw std::runtime_error(message);
    }
    static void read(png_structp png, png_bytep to, std::size_t count) {
        auto& self = *static_cast<Reader*>(png_get_io_ptr(png));
        if (self.m_at + count > self.m_bytes.size())
            throw std::runtime_error("the file ends early");
        std::copy_n(self.m_bytes.begin() + static_cast<std::ptrdiff_t>(self.m_at), count, to);
        self.m_at += count;
    }

    const std::string& m_bytes;
    std::size_t m_at = 0;
    png_structp m_png = nullptr;
    png_infop m_info = nullptr;
};

}  // namespace

TEST_CASE("a PNG of red, green and blue holds samples and texts, also beyond ASCII",
          "[common][png]") {
    const std::vector<std::uint8_t> samples = {0, 1, 2, 253, 254, 255, 7, 8, 9, 10, 11, 12};
    const std::map<std::string, std::string> texts = {
        {"Software", "terravox"},
        {"Copyright", "Škofja Loka, © 2026"},
        {"terravox:scene", "[camera]\nfov_deg = 40\n" + std::string(100'000, '#')},
        {"empty", ""},
        {std::string(79, 'k'), "the longest keyword"}};
    std::vector<png::Text> given;
    for (const auto& [keyword, value] : texts)
        given.push_back({keyword, value});
    const std::string bytes = png::encode(samples, {2, 2, 3}, given);
    const Reader back(bytes);
    CHECK(back.texts() == texts);
    CHECK(back.samples() == samples);
    CHECK(bytes == png::encode(samples, {2, 2, 3}, given));
}

TEST_CASE("a text that PNG does not allow is refused", "[common][png]") {
    const std::vector<std::uint8_t> samples(3);
    struct Case {
        const char* name;
        png::Text text;
    };
    const auto c = GENERATE(values<Case>({{"no keyword", {"", "a"}},
                                          {"a space before", {" a", "a"}},
                                          {"a space behind", {"a ", "a"}},
                                          {"a line break", {"a\nb", "a"}},
                                          {"beyond ASCII", {"Š", "a"}},
                                          {"too long", {std::string(80, 'k'), "a"}},
                                          {"0 in the value", {"a", std::string("b\0c", 3)}}}));
    DYNAMIC_SECTION(c.name) {
        const std::vector<png::Text> texts{c.text};
        CHECK_THROWS_AS(png::encode(samples, {1, 1, 3}, texts), util::Error);
    }
}

TEST_CASE("a PNG's shape and its samples must agree", "[common][png]") {
    const std::vector<std::uint8_t> samples(12);
    CHECK_THROWS_AS(png::encode(samples, {0, 4, 3}), util::Error);
    CHECK_THROWS_AS(png::encode(samples, {4, -1, 3}), util::Error);
    CHECK_THROWS_AS(png::encode(samples, {12, 1, 1}), util::Error);
    CHECK_THROWS_AS(png::encode(samples, {4, 2, 3}), util::Error);
    CHECK_THROWS_AS(png::encode(samples, {1 << 30, 1 << 30, 4}), util::Error);
}
