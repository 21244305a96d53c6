#include "raytracer/farm/net/handshake.hpp"

#include "raytracer/farm/net/endpoint.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::net;
using terravox::test::contains;
using Outcome = ListenerHandshake::Outcome;

namespace {

constexpr const char* kHandshakeToken = "a token of the tests";

auto encode_hello(const Bytes& bytes) {
    return std::span<const std::byte, kHello_bytes>(bytes);
}
auto make_answer(const Bytes& bytes) {
    return std::span<const std::byte, kAnswer_bytes>(bytes);
}

struct Ends {
    DiallerHandshake dialler;
    ListenerHandshake listener;
    Bytes proof;
    /// Both hellos have been exchanged.
    Ends(const char* of_dialler, const char* of_listener)
        : dialler(of_dialler), listener(of_listener) {
        const auto step = listener.take(dialler.hello());
        REQUIRE(step.outcome == Outcome::kMore);
        REQUIRE(step.reply.size() == kHello_bytes);
        proof = dialler.prove(encode_hello(step.reply));
    }
};

}  // namespace

TEST_CASE("both sides accept a peer with the token", "[common][net][handshake]") {
    Ends ends(kHandshakeToken, kHandshakeToken);
    CHECK(ends.listener.take(ends.proof).outcome == Outcome::kProven);
    CHECK_NOTHROW(ends.dialler.check(make_answer(ends.listener.answer(Verdict::kWelcome))));
}

TEST_CASE("the handshake works byte by byte, too, and reads nothing beyond its end",
          "[common][net][handshake]") {
    DiallerHandshake dialler(kHandshakeToken);
    ListenerHandshake listener(kHandshakeToken);
    Bytes said;
    for (const std::byte byte : dialler.hello()) {
        REQUIRE(listener.wanted() == kHello_bytes - said.size());
        said.push_back(byte);
        const auto step = listener.take({&byte, 1});
        REQUIRE(step.outcome == Outcome::kMore);
        REQUIRE(step.reply.empty() == (said.size() < kHello_bytes));
        if (!step.reply.empty())
            said = dialler.prove(encode_hello(step.reply));
    }
    REQUIRE(listener.wanted() == kProof_bytes);
    for (std::size_t i = 0; i + 1 < said.size(); ++i)
        REQUIRE(listener.take({&said[i], 1}).outcome == Outcome::kMore);
    CHECK(listener.take({&said.back(), 1}).outcome == Outcome::kProven);
    CHECK(listener.wanted() == 0);
}

TEST_CASE("another token shows, whichever end has it", "[common][net][handshake]") {
    for (const char* other : {"another token of the tests", "a token of the testS", ""}) {
        INFO(other);
        Ends ends(kHandshakeToken, other);
        CHECK(ends.listener.take(ends.proof).outcome == Outcome::kWrongToken);
        // A listener without the token cannot make the proof of a welcome.
        CHECK_THROWS_AS(ends.dialler.check(make_answer(ends.listener.answer(Verdict::kWelcome))),
                        RefusedError);
        CHECK_THROWS_WITH(ends.dialler.check(make_answer(ends.listener.answer(Verdict::kWelcome))),
                          contains("does not know the token"));
    }
}

TEST_CASE("a proof is worth nothing on another connection, or sent back",
          "[common][net][handshake]") {
    Ends first(kHandshakeToken, kHandshakeToken), second(kHandshakeToken, kHandshakeToken);
    CHECK(second.listener.take(first.proof).outcome == Outcome::kWrongToken);
    Ends mirrored(kHandshakeToken, kHandshakeToken);
    Bytes echo{std::byte{0}};
    echo.insert(echo.end(), mirrored.proof.begin(), mirrored.proof.end());
    CHECK_THROWS_AS(mirrored.dialler.check(make_answer(echo)), RefusedError);
}

TEST_CASE("one bit changed anywhere in a proof is a wrong token", "[common][net][handshake]") {
    for (std::size_t bit = 0; bit < kProof_bytes * 8; ++bit) {
        INFO(bit);
        Ends ends(kHandshakeToken, kHandshakeToken);
        ends.proof[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
        REQUIRE(ends.listener.take(ends.proof).outcome == Outcome::kWrongToken);
        auto answer = Ends(kHandshakeToken, kHandshakeToken).listener.answer(Verdict::kWelcome);
        answer[1 + bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
        REQUIRE_THROWS_AS(ends.dialler.check(make_answer(answer)), RefusedError);
    }
}

TEST_CASE("a dialler learns why it is refused", "[common][net][handshake]") {
    struct Case {
        Verdict verdict;
        const char* why;
        bool for_good;
    };
    for (const Case c :
         {Case{Verdict::kWrongToken, "wrong token", true}, Case{Verdict::kBusy, "no room", false},
          Case{Verdict::kCertificates, "certificates", true},
          Case{static_cast<Verdict>(77), "not a Terravox farm", true}}) {
        INFO(c.why);
        Ends ends(kHandshakeToken, kHandshakeToken);
        const auto answer = ends.listener.answer(c.verdict);
        CHECK(Bytes(answer.begin() + 1, answer.end()) == Bytes(kProof_bytes));
        bool for_good = false;
        std::string why;
        try {
            ends.dialler.check(make_answer(answer));
        } catch (const RefusedError& e) {
            for_good = true;
            why = e.what();
        } catch (const util::Error& e) {
            why = e.what();
        }
        CHECK(for_good == c.for_good);
        CHECK_THAT(why, contains(c.why));
    }
}

TEST_CASE("both sides report another version", "[common][net][handshake]") {
    DiallerHandshake dialler(kHandshakeToken);
    ListenerHandshake listener(kHandshakeToken);
    auto hello = dialler.hello();
    hello[kHandshakeMagic.size()] = std::byte{9};
    const auto step = listener.take(hello);
    CHECK(step.outcome == Outcome::kAnotherVersion);
    CHECK(listener.version_of_peer() == 9);
    CHECK(step.reply.size() == kHello_bytes);
    CHECK_THROWS_WITH(dialler.prove(encode_hello(hello)), contains("version 9; allowed: 1"));
}

TEST_CASE("an invalid hello is recognised by its first byte", "[common][net][handshake]") {
    for (const char* said :
         {"GET / HTTP/1.1\r\n\r\n", "\x16\x03\x01", "PRI * HTTP/2.0", "TVX-FARN", "tvx-farm"}) {
        INFO(said);
        ListenerHandshake listener(kHandshakeToken);
        const auto step = listener.take(std::as_bytes(std::span(std::string_view(said))));
        CHECK(step.outcome == Outcome::kNotTerravox);
        CHECK(step.reply.empty());
    }
    DiallerHandshake dialler(kHandshakeToken);
    CHECK_THROWS_WITH(dialler.prove(encode_hello(Bytes(kHello_bytes, std::byte{'H'}))),
                      contains("is not a Terravox farm"));
}
