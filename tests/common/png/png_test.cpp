#include "common/png/png.hpp"

#include <libdeflate.h>
#include <png.h>

#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;

namespace {

std::uint32_t number_at(const std::string& bytes, std::size_t at) {
    std::uint32_t out = 0;
    for (std::size_t i = 0; i < 4; ++i)
        out = out << 8 | static_cast<unsigned char>(bytes.at(at + i));
    return out;
}

/// The texts of a file by their keywords, whose chunks are verified.
/// Ref: PNG specification, 5.3 (chunks), 11.3.4 (texts).
std::map<std::string, std::string> list_texts(const std::string& bytes) {
    constexpr std::size_t kSignature = 8;
    std::map<std::string, std::string> out;
    for (std::size_t at = kSignature; at < bytes.size();) {
        const std::size_t length = number_at(bytes, at);
        const std::string typed = bytes.substr(at + 4, 4 + length);
        at += 8 + length;
        if (libdeflate_crc32(0, typed.data(), typed.size()) != number_at(bytes, at))
            throw std::runtime_error("a chunk has another checksum");
        at += 4;
        const std::string type = typed.substr(0, 4);
        const std::string data = typed.substr(4);
        const std::size_t end = data.find('\0');
        if (type == "tEXt")
            out[data.substr(0, end)] = data.substr(end + 1);
        if (type == "iTXt" && data.substr(end, 5) == std::string(5, '\0'))
            out[data.substr(0, end)] = data.substr(end + 5);
    }
    return out;
}

std::vector<std::uint8_t> read_samples(const std::string& bytes) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    if (png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()) == 0)
        throw std::runtime_error(image.message);
    image.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> out(PNG_IMAGE_SIZE(image));
    if (png_image_finish_read(&image, nullptr, out.data(), 0, nullptr) == 0)
        throw std::runtime_error(image.message);
    return out;
}

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
    CHECK(list_texts(bytes) == texts);
    CHECK(read_samples(bytes) == samples);
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
