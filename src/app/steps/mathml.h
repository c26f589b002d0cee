/* Equations as MathML, put together from string literals. */
#ifndef SL_APP_STEPS_MATHML_H
#define SL_APP_STEPS_MATHML_H

#define M_I(name) "<mi>" name "</mi>"
#define M_N(number) "<mn>" number "</mn>"
#define M_O(sign) "<mo>" sign "</mo>"
#define M_T(text) "<mtext>" text "</mtext>"
#define M_ROW(...) "<mrow>" __VA_ARGS__ "</mrow>"
#define M_FRAC(above, below) "<mfrac><mrow>" above "</mrow><mrow>" below "</mrow></mfrac>"
#define M_SUB(base, index) "<msub><mrow>" base "</mrow><mrow>" index "</mrow></msub>"
#define M_SUP(base, power) "<msup><mrow>" base "</mrow><mrow>" power "</mrow></msup>"
#define M_SUBSUP(base, index, power) \
    "<msubsup><mrow>" base "</mrow><mrow>" index "</mrow><mrow>" power "</mrow></msubsup>"
#define M_SUM(index) "<munder><mo>&#x2211;</mo><mrow>" index "</mrow></munder>"
#define M_SQRT(x) "<msqrt><mrow>" x "</mrow></msqrt>"
#define M_TIMES M_O("&#x22C5;")
#define M_BRACED(x) M_ROW(M_O("(") x M_O(")"))
#define M_ABS(x) M_ROW(M_O("|") x M_O("|"))

#endif
